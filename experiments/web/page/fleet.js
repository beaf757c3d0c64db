// The page: listens to the server's events, and shows the fleet or one robot.

import {byId, clock, count, milliseconds, number, put} from './text.js';
import {Model} from './model.js';
import {showBrokers} from './brokers.js';
import {showRobots, showRows} from './robots.js';
import {FleetMap} from './map.js';
import {Chart} from './chart.js';
import {announced, forgetTimeLine, showTimeLine} from './time_line.js';
import {RobotPage, isRobotId} from './robot_page.js';
import {showTalks} from './talks.js';
import {showTopics} from './topics.js';
import {RecordingBar} from './recording.js';

const model = new Model();
const map = new FleetMap(byId('map'));
const robotPage = new RobotPage(order);
const recordingBar = new RecordingBar();
const messages = new Chart(byId('chart-messages'), {
    title: 'Messages a second', lines: [{key: 'messages', class: 'line'}], least: 5,
    text: (value) => number(value),
});
const delay = new Chart(byId('chart-delay'), {
    title: 'Delay of an echo', least: 1,
    lines: [{key: 'delay_ms', class: 'line'}, {key: 'worst_delay_ms', class: 'line worst'}],
    text: (value, isShort) => (isShort ? number(value) + ' ms' : milliseconds(value)),
});

let hasServer = true;
let lastHeardAt = performance.now();
let isDue = false;
let tablesDueAt = 0;
const urgentRobots = new Set();
const tablesEveryMs = 1000;  // nobody reads faster; the map follows each change
let followed;  // the last command, and where its progress is told

function schedule() {
    if (isDue) return;
    isDue = true;
    requestAnimationFrame(() => {
        isDue = false;
        show();
    });
}

function show() {
    showAlarm();
    recordingBar.show(model);
    const isTurnOfTables = performance.now() >= tablesDueAt;
    if (isTurnOfTables) {
        tablesDueAt = performance.now() + tablesEveryMs;
        showSummary();
    }
    if (robotPage.id !== undefined) return robotPage.show(model);
    if (isTurnOfTables) {
        showBrokers(model);
        showRobots(model);
        showTimeLine(model);
        showTalks(model);
        showTopics(model);
    }
    showRows(model, urgentRobots);
    urgentRobots.clear();
    showMap();
}

function showMap() {
    const placed = map.draw(model, [...model.robots.values()]);
    put(byId('map-hint'), placed > 0 || model.robots.size === 0 ? ''
        : 'No robot has said where it is. Robots that publish their location on a topic with their id in it, such as ' +
          'robots/abcd1234/pose, are shown here; romano web --ask 1 asks them all.');
    const label = `Map of ${count(placed, 'robot')}; the table of robots tells their places`;
    if (byId('map').ariaLabel !== label) byId('map').ariaLabel = label;
}

/** News of brokers, and what people do, are shown at once. */
function scheduleAll() {
    tablesDueAt = 0;
    schedule();
}

function showCharts() {
    const deaths = [...model.happenings.values()].filter((h) => h.kind === 'broker-died');
    messages.show(model.seconds, deaths, model.now());
    delay.show(model.seconds, deaths, model.now());
}

function showSummary() {
    if (model.brokers.size === 0 && model.robots.size === 0) return;
    const alive = [...model.brokers.values()].filter((broker) => broker.alive).length;
    const last = model.seconds[model.seconds.length - 1];
    const parts = [
        count(alive, 'broker') + (alive < model.brokers.size ? ` of ${model.brokers.size} alive` : ''),
        model.cluster.leader ? `${model.cluster.leader} leads` : 'nobody leads',
        count(model.robots.size, 'robot'),
    ];
    put(byId('seen-by'), model.recording ? 'A recording of what one broker delivered.' : `Seen through the broker at ${model.watch.broker}. An echo is a message that this page’s server sends to itself through it.`);
    if (last) parts.push(`${number(last.messages)} messages/s`);
    put(byId('summary'), parts.join(' · '));
}

function showAlarm() {
    let text = '';
    if (!hasServer) text = 'romano web does not answer. What you see is what was last heard.';
    else if (model.recording) text = model.watch.is_linked ? '' : 'No broker answered the recorder at this time: what happened is not known.';
    else if (!model.watch.is_linked && model.watch.since_unix_ms) {
        text = `The broker does not answer since ${clock(model.watch.since_unix_ms)}. Commands are refused; it is asked again each second.`;
    } else if (!model.watch.is_linked) text = 'Asking for the broker…';
    const alarm = byId('alarm');
    alarm.hidden = text === '';
    put(alarm, text);
}

/** Tells the server to command robots; says in `status` what came of it. */
async function order(path, body, status) {
    if (followed?.status === status) followed = undefined;
    put(status, 'Sending…');
    try {
        const answer = await fetch(path, {
            method: 'POST', headers: {'Content-Type': 'application/json'}, body: JSON.stringify(body),
        });
        const said = await answer.json();
        if (!answer.ok) return put(status, 'Refused: ' + said.error);
        put(status, `Sent at ${clock(model.now())}: ${said.words}, to ${count(said.robots, 'robot')}.`);
        follow(said.command, status);
    } catch {
        put(status, 'Not sent: romano web does not answer.');
    }
}

/** Until the broker has all messages of the command. */
function follow(command, status) {
    followed = {command, status, text: status.textContent};
    showFollowed();
}
function showFollowed() {
    if (!followed) return;
    const happening = model.happenings.get(followed.command);
    if (!happening) return;
    const done = happening.confirmed + happening.refused;
    if (done === 0) return;
    const lost = happening.refused > 0 ? `, ${happening.refused} did not get out` : '';
    put(followed.status, `${followed.text} The broker has ${count(happening.confirmed, 'message')}${lost}.`);
}

function route() {
    const robot = location.hash.match(/^#\/robots\/(.+)$/)?.[1];
    const isRobot = robot !== undefined && isRobotId(robot);
    const wasRobot = robotPage.id;
    robotPage.id = undefined;
    if (isRobot) robotPage.open(robot);
    byId('fleet').hidden = isRobot;
    byId('robot').hidden = !isRobot;
    document.title = isRobot ? `Robot ${robot} – ROMANO fleet` : 'ROMANO fleet';
    if (isRobot) byId('robot-title').focus();
    if (isRobot || wasRobot !== undefined) window.scrollTo(0, 0);
    tablesDueAt = 0;
    show();
    showCharts();
}

function listen() {
    const events = new EventSource('/api/events');
    events.addEventListener('state', (event) => {
        forgetTimeLine();
        model.setState(JSON.parse(event.data));
        tablesDueAt = 0;
        heard();
        showCharts();
    });
    events.addEventListener('change', (event) => {
        const change = JSON.parse(event.data);
        const news = change.time_line.filter((h) => !model.happenings.has(h.number)).map(announced).filter((t) => t !== '');
        for (const robot of model.change(change)) urgentRobots.add(robot);
        if (news.length > 0) put(byId('announcer'), news.join('. '));
        if (change.time_line.length > 0) tablesDueAt = 0;
        heard();
        showFollowed();
        if (change.seconds.length > 0) showCharts();
    });
    events.addEventListener('error', () => {
        hasServer = false;
        schedule();
        if (events.readyState === EventSource.CLOSED) setTimeout(listen, 1000);
    });
}

function heard() {
    hasServer = true;
    lastHeardAt = performance.now();
    schedule();
}

byId('stop-all').addEventListener('click', () => order('/api/stop', {}, byId('stop-said')));
byId('find').addEventListener('input', scheduleAll);
byId('map').addEventListener('click', (event) => {
    const found = map.robotAt(event.offsetX, event.offsetY);
    if (found) location.hash = '#/robots/' + found;
});
window.addEventListener('hashchange', route);
window.addEventListener('resize', () => {
    schedule();
    showCharts();
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    map.clear();
    robotPage.map.clear();
    scheduleAll();
});
setInterval(() => {
    // The server tells each second how things go.
    if (performance.now() - lastHeardAt > 5000) hasServer = false;
    scheduleAll();
}, 1000);
route();
listen();
