// Who talks to whom: what the robots at each broker say and are told, and which brokers hear each other.

import {byId, make, number, octets, put} from './text.js';

const columns = ['Broker', 'Its robots say', 'They are told', 'To peers', 'Hears'];
const rows = new Map();

function makeRow() {
    const row = {node: make('tr', {role: 'row'}), cells: columns.map((name) => make('td', {role: 'cell', 'data-column': name}))};
    row.node.append(...row.cells);
    return row;
}

/** Of each home, what its robots said and were told in the last second. */
function ratesByHome(model) {
    const rates = new Map();
    for (const robot of model.robots.values()) {
        const rate = rates.get(robot.home) ?? {said: 0, told: 0};
        rate.said += robot.messages_per_s;
        rate.told += robot.told_per_s;
        rates.set(robot.home, rate);
    }
    return rates;
}

/** Living members of the view whose packets reach this broker; and which do not. */
function heard(model, broker) {
    const others = model.cluster.members.filter((name) => name !== broker.name && model.brokers.get(name)?.alive);
    if (!broker.alive || !model.cluster.members.includes(broker.name)) return '–';
    const deaf = others.filter((name) => broker.does_not_hear.includes(name));
    if (others.length === 0) return 'no other broker is there';
    if (deaf.length === 0) return others.length === 1 ? others[0] : `all ${others.length} others`;
    return `not ${deaf.join(', ')}`;
}

export function showTalks(model) {
    const rates = ratesByHome(model);
    const names = [...new Set([...model.brokers.keys(), ...rates.keys()])].sort();
    for (const [name, row] of rows) {
        if (names.includes(name)) continue;
        row.node.remove();
        rows.delete(name);
    }
    names.forEach((name, at) => {
        const broker = model.brokers.get(name);
        if (!rows.has(name)) rows.set(name, makeRow());
        const row = rows.get(name);
        const {said, told} = rates.get(name) ?? {said: 0, told: 0};
        const isHeard = broker === undefined ? '–' : heard(model, broker);
        const texts = [name, `${number(said)}/s`, `${number(told)}/s`,
                       broker?.alive && broker.to_peers_octets_per_s !== undefined ? octets(broker.to_peers_octets_per_s) : '–', isHeard];
        row.cells.forEach((cell, column) => put(cell, texts[column]));
        row.node.classList.toggle('deaf', isHeard.startsWith('not '));
        const list = byId('talks');
        if (list.children[at] !== row.node) list.insertBefore(row.node, list.children[at] ?? null);
    });
}
