// A card for each broker.

import {age, byId, count, make, milliseconds, number, octets, put} from './text.js';

const cards = new Map();

function makeCard() {
    const card = {node: make('li', {class: 'card broker'})};
    card.name = make('span', {class: 'name'});
    card.badge = make('span', {class: 'badge'});
    card.robots = make('b', {});
    card.robotsWord = make('span', {});
    card.sessions = make('dd', {});
    card.load = make('dd', {title: 'Processor time of its process in the last five seconds, of one core'});
    card.condition = make('dd', {title: 'Battery or load of its machine, as its rank has it, in steps of a quarter'});
    card.peers = make('dd', {});
    card.turn = make('dd', {title: 'The longest that it did one thing and nothing else, in the last half minute to minute'});
    card.addresses = make('dd', {class: 'mono'});
    card.warning = make('p', {class: 'warning'});
    card.node.append(
        make('h3', {}, card.name, card.badge),
        make('p', {class: 'big'}, card.robots, ' ', card.robotsWord),
        make('dl', {}, make('dt', {}, 'Sessions'), card.sessions, make('dt', {}, 'Load'), card.load,
             make('dt', {}, 'Condition'), card.condition, make('dt', {}, 'To peers'), card.peers,
             make('dt', {}, 'Longest turn'), card.turn,
             make('dt', {}, 'Serves'), card.addresses),
        card.warning);
    return card;
}

export function showBrokers(model) {
    const list = byId('brokers');
    const robots = model.robotsByHome();
    for (const [name, card] of cards) {
        if (model.brokers.has(name)) continue;
        card.node.remove();
        cards.delete(name);
    }
    for (const name of [...model.brokers.keys()].sort()) {
        const broker = model.brokers.get(name);
        const isNew = !cards.has(name);
        if (isNew) cards.set(name, makeCard());
        const card = cards.get(name);
        card.node.dataset.home = model.colourOf(name);
        card.node.classList.toggle('dead', !broker.alive);
        put(card.name, name);
        const leads = broker.alive && name === model.cluster.leader;
        put(card.badge, broker.alive ? (leads ? 'leads' : '') : `dead for ${age(model.now() - broker.since_unix_ms)}`);
        card.badge.classList.toggle('bad', !broker.alive);
        const here = robots.get(name) ?? 0;
        put(card.robots, here);
        put(card.robotsWord, here === 1 ? 'robot' : 'robots');
        put(card.sessions, broker.alive ? `${broker.sessions}, ${broker.connected} connected` : 'none');
        put(card.load, broker.alive && broker.cpu_percent !== undefined ? `${number(broker.cpu_percent)} % of a core` : '–');
        put(card.condition, broker.alive && broker.condition !== undefined ? `${broker.condition} of 100` : '–');
        put(card.peers, broker.to_peers_octets_per_s === undefined || !broker.alive
            ? '–' : octets(broker.to_peers_octets_per_s));
        put(card.turn, broker.alive && broker.longest_turn_ms > 0 ? milliseconds(broker.longest_turn_ms) : '–');
        put(card.addresses, broker.addresses.length > 0 ? broker.addresses.join(' ') : '–');
        put(card.warning, broker.alive && broker.cannot_take > 0
            ? `It cannot take over ${count(broker.cannot_take, 'address', 'addresses')} of others (see its log).` : '');
        if (isNew) list.append(card.node);
    }
}
