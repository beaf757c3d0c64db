// Who says what to whom: a line for each topic, from the robots of a broker to those of a broker.

import {byId, count, make, number, put} from './text.js';

const mostLines = 24;
const lines = new Map();
const columns = ['Who says it', 'On the topic', 'To whom', 'Messages'];

function makeLine() {
    const line = {node: make('tr', {role: 'row'}), cells: []};
    columns.forEach((column, at) => {
        const cell = make('td', {role: 'cell', 'data-column': column});
        const isEnd = at === 0 || at === 2;
        line.cells.push(isEnd ? cell.appendChild(make('span', {class: 'chip'})) : cell);
        line.node.append(cell);
    });
    line.cells[1].classList.add('mono');
    line.bar = make('span', {class: 'bar', 'aria-hidden': 'true'});
    line.rate = make('span', {});
    line.cells[3].append(line.bar, line.rate);
    return line;
}

const robotsOf = (broker) => `robots of ${broker}`;

function toWhom(talk) {
    if (talk.to !== undefined) return robotsOf(talk.to);
    return talk.topic === 'common' ? 'all robots' : 'who subscribed';
}

/** The busiest, in an order in which they stay. */
function shownTalks(model) {
    const busiest = model.talks.filter((talk) => talk.messages_per_s > 0)
        .sort((a, b) => b.messages_per_s - a.messages_per_s).slice(0, mostLines);
    const key = (talk) => JSON.stringify([talk.topic, talk.from ?? '', talk.to ?? '']);
    return busiest.map((talk) => ({key: key(talk), talk})).sort((a, b) => (a.key < b.key ? -1 : 1));
}

export function showTopics(model) {
    const shown = shownTalks(model);
    const keep = new Set(shown.map(({key}) => key));
    for (const [key, line] of lines) {
        if (keep.has(key)) continue;
        line.node.remove();
        lines.delete(key);
    }
    const most = Math.max(1, ...shown.map(({talk}) => talk.messages_per_s));
    const body = byId('topics');
    shown.forEach(({key, talk}, at) => {
        if (!lines.has(key)) lines.set(key, makeLine());
        const {node, cells, bar, rate} = lines.get(key);
        put(cells[0], talk.from === undefined ? 'others' : robotsOf(talk.from));
        cells[0].dataset.home = model.colourOf(talk.from);
        put(cells[1], talk.topic);
        put(cells[2], toWhom(talk));
        cells[2].dataset.home = model.colourOf(talk.to);
        put(rate, `${number(talk.messages_per_s)}/s`);
        bar.style.width = `${Math.max(2, Math.round(60 * talk.messages_per_s / most))}px`;
        if (body.children[at] !== node) body.insertBefore(node, body.children[at] ?? null);
    });
    const active = model.talks.filter((talk) => talk.messages_per_s > 0).length;
    put(byId('topics-hint'), active === 0 ? 'Nobody says anything just now.'
        : active > mostLines ? `The busiest ${mostLines} of ${count(active, 'line')}; /api/state has all.` : '');
}
