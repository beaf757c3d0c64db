// The table of robots. Rows are kept, and only what is another text is written.

import {age, byId, count, make, number, put} from './text.js';

const mostRows = 250;
const rowsAFrame = 40;
const rows = new Map();
let listed = [];
let nextRow = 0;
const columns = ['Robot', 'State', 'Home', 'Heartbeat', 'Messages', 'Place', 'Battery'];

function makeRow(id) {
    const row = {node: make('tr', {role: 'row'}), cells: []};
    columns.forEach((column, at) => {
        const cell = make(at === 0 ? 'th' : 'td', {
            'data-column': column, scope: at === 0 ? 'row' : undefined, role: at === 0 ? 'rowheader' : 'cell',
        });
        let inner = cell;
        if (at === 0) inner = cell.appendChild(make('a', {href: '#/robots/' + id, class: 'mono'}));
        if (at === 1) inner = cell.appendChild(make('span', {class: 'state'}));
        if (at === 2) inner = cell.appendChild(make('span', {class: 'chip'}));
        row.cells.push(inner);
        row.node.append(cell);
    });
    return row;
}

export function placeText(place) {
    const metres = (mm) => (mm / 1000).toFixed(2);
    const text = `${metres(place.x_mm)}, ${metres(place.y_mm)} m, ${Math.round(place.heading_mdeg / 1000)}°`;
    return text.replaceAll('-', '−');
}

export function heartbeatText(model, robot) {
    if (robot.heartbeat_unix_ms === undefined) return 'none';
    return age(model.now() - robot.heartbeat_unix_ms) + ' ago';
}

export const batteryText = (robot) =>
    robot.battery_mv === undefined ? '' : (robot.battery_mv / 1000).toFixed(2) + ' V';

function showRow(model, row, robot) {
    const texts = [robot.robot, robot.state, robot.home, heartbeatText(model, robot),
                   number(robot.messages_per_s) + '/s', robot.place ? placeText(robot.place) : '',
                   batteryText(robot)];
    texts.forEach((text, at) => {
        put(row.cells[at], text === '' ? '–' : text);
        row.cells[at].classList.toggle('none', text === '');
    });
    row.cells[1].dataset.state = robot.state;
    row.cells[2].dataset.home = model.colourOf(robot.home);
}

/** What must not wait, where these robots are at home and how they are; and the next rows in turn. */
export function showRows(model, urgent) {
    const show = (id) => {
        const robot = model.robots.get(id);
        const row = rows.get(id);
        if (robot && row) showRow(model, row, robot);
    };
    urgent.forEach(show);
    const turn = Math.min(rowsAFrame, listed.length);
    for (let n = 0; n < turn; ++n) show(listed[(nextRow + n) % listed.length]);
    nextRow = (nextRow + turn) % Math.max(1, listed.length);
}

/** Which rows there are. */
export function showRobots(model) {
    const wanted = byId('find').value.trim().toLowerCase();
    const matches = (robot) => wanted === '' || robot.robot.includes(wanted) ||
        robot.home.toLowerCase().includes(wanted) || robot.state.includes(wanted);
    const found = [...model.robots.keys()].sort().filter((id) => matches(model.robots.get(id)));
    listed = found.slice(0, mostRows);
    const keep = new Set(listed);
    for (const [id, row] of rows) {
        if (keep.has(id)) continue;
        row.node.remove();
        rows.delete(id);
    }
    const body = byId('robots');
    listed.forEach((id, at) => {
        const isNew = !rows.has(id);
        if (isNew) rows.set(id, makeRow(id));
        const row = rows.get(id);
        if (body.children[at] !== row.node) body.insertBefore(row.node, body.children[at] ?? null);
        if (isNew) showRow(model, row, model.robots.get(id));
    });
    put(byId('robot-count'), wanted === '' ? model.robots.size : `${found.length} of ${model.robots.size}`);
    let hint = '';
    if (model.robots.size === 0) hint = 'No robot is known to the brokers.';
    else if (found.length === 0) hint = 'No robot has this in its id, home or state.';
    else if (found.length > mostRows) hint = `The first ${mostRows} of ${count(found.length, 'robot')} are listed: find others by id.`;
    put(byId('robots-hint'), hint);
}
