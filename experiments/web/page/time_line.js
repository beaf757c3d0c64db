// What happened, the newest first, in words.

import {byId, clock, count, make, milliseconds, put, shown} from './text.js';

const mostShown = 60;
const items = new Map();

function who(happening) {
    const named = happening.robots ?? [];
    if (happening.robot_count === 1) return named[0];
    return count(happening.robot_count ?? 0, 'robot');
}

const sentences = {
    'broker-found': (h) => `${h.to} is a broker too`,
    'broker-died': (h) => `${h.to} died`,
    'broker-back': (h) => `${h.to} is back after ${milliseconds(h.took_ms ?? 0)}`,
    'leader': (h) => `${h.to} leads` + (h.took_ms >= 1 ? `; nobody did for ${milliseconds(h.took_ms)}` : ''),
    'take-over': (h) => `${h.to} took over ${who(h)} of ${h.from}` +
        (h.took_ms >= 1 ? `, ${milliseconds(h.took_ms)} after the word of its death` : ''),
    'hand-back': (h) => `${h.from} gave ${who(h)} back to ${h.to}`,
    'roam': (h) => `${who(h)} went from ${h.from} to ${h.to}`,
    'robots-found': (h) => `${who(h)} came to ${h.to}`,
    'robots-left': (h) => `${who(h)} left`,
    'robots-silent': (h) => `${who(h)} fell silent`,
    'robots-away': (h) => `${who(h)} went away; messages wait`,
    'robots-back': (h) => `${who(h)} can be heard again`,
    'watch-lost': () => 'the broker of this page does not answer',
    'watch-back': (h) => `the broker of this page answers again, after ${milliseconds(h.took_ms ?? 0)}`,
    'commands': (h) => `${h.commands} commands; the last: ${h.what}, to ${who(h)}`,
    'command': (h) => `command: ${h.what}, to ${who(h)}` +
        (h.refused > 0 ? `; ${count(h.refused, 'message')} did not get out` : ''),
};
const loud = new Set(['broker-died', 'broker-back', 'leader', 'take-over', 'watch-lost', 'watch-back', 'robots-silent']);

export function sentence(happening) {
    const say = sentences[happening.kind];
    let text = say ? say(happening) : happening.kind;
    if (happening.silence_ms !== undefined) {
        text += `; longest silence ${milliseconds(happening.silence_ms)}`;
    }
    return text;
}

/** Several commands in a row are one line: a joystick must not hide what happens to brokers. */
function withRowsOfCommands(newest) {
    const lines = [];
    for (const happening of newest) {
        const last = lines[lines.length - 1];
        const isCommand = happening.kind === 'command';
        if (isCommand && last?.row) last.row.push(happening);
        else lines.push({...happening, row: isCommand ? [happening] : undefined});
    }
    return lines.flatMap((line) => {
        if (!line.row || line.row.length < 3) return line.row ?? [line];
        return [{...line, kind: 'commands', commands: line.row.length, number: 'row ' + line.row[line.row.length - 1].number}];
    });
}

function makeItem(happening) {
    const words = make('span', {class: 'words'});
    const time = make('time', {});
    const node = make('li', {'data-kind': happening.kind}, time, make('span', {class: 'mark', 'aria-hidden': 'true'}), words);
    return {node, time, words};
}

export function showTimeLine(model) {
    const list = byId('time-line');
    const newest = withRowsOfCommands([...model.happenings.values()].sort((a, b) => b.number - a.number)).slice(0, mostShown);
    const keep = new Set(newest.map((h) => h.number));
    for (const [number, item] of items) {
        if (keep.has(number)) continue;
        item.node.remove();
        items.delete(number);
    }
    newest.forEach((happening, at) => {
        if (!items.has(happening.number)) items.set(happening.number, makeItem(happening));
        const item = items.get(happening.number);
        put(item.words, sentence(happening));
        put(item.time, clock(happening.unix_ms));
        if (list.children[at] !== item.node) list.insertBefore(item.node, list.children[at] ?? null);
    });
    list.classList.toggle('empty', newest.length === 0);
}

export function forgetTimeLine() {
    for (const item of items.values()) item.node.remove();
    items.clear();
}

/** What a screen reader says of news; nothing for what is no news to it. */
export const announced = (happening) => (loud.has(happening.kind) ? shown(sentence(happening)) : '');
