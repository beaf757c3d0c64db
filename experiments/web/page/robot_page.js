// One robot: how it is, what it and others say, and what it is told to do.

import {byId, clock, make, number, put, shown} from './text.js';
import {batteryText, heartbeatText, placeText} from './robots.js';
import {FleetMap} from './map.js';

const fetchEveryMs = 300;

export class RobotPage {
    constructor(order) {
        this.map = new FleetMap(byId('path'));
        this.id = undefined;
        this.fetchedAt = 0;
        this.facts = new Map();
        byId('move').addEventListener('submit', (event) => {
            event.preventDefault();
            order(`/api/robots/${this.id}/move`,
                  {movement: byId('movement').value, amount: byId('amount').value.trim()}, byId('robot-said'));
        });
        byId('robot-stop').addEventListener('click', () => {
            order(`/api/robots/${this.id}/stop`, {}, byId('robot-said'));
        });
        byId('movement').addEventListener('change', () => {
            const turns = byId('movement').value.startsWith('rotate');
            const amount = byId('amount').value;
            if (turns && !amount.endsWith('deg')) byId('amount').value = '90deg';
            if (!turns && amount.endsWith('deg')) byId('amount').value = '100mm';
        });
    }

    open(id) {
        this.id = id;
        this.fetchedAt = 0;
        this.map.clear();
        put(byId('robot-said'), '');
        put(byId('robot-title'), 'Robot ' + id);
        byId('messages').replaceChildren();
        put(byId('messages-hint'), '');
    }

    show(model) {
        const robot = model.robots.get(this.id);
        byId('robot-stop').disabled = !robot;
        const facts = robot ? [
            ['State', robot.state], ['Home', robot.home], ['Heartbeat', heartbeatText(model, robot)],
            ['Last heard', robot.heard_unix_ms === undefined ? 'not yet' : clock(robot.heard_unix_ms)],
            ['Messages', number(robot.messages_per_s) + '/s'],
            ['Place', robot.place ? placeText(robot.place) : 'not said'],
            ['Battery', batteryText(robot) || 'not said'], ['Form', robot.form], ['Client', robot.client],
        ] : [['State', 'not known to the brokers']];
        this.showFacts(facts);
        const placed = this.map.draw(model, robot ? [robot] : []);
        put(byId('path-hint'), placed > 0 ? '' : 'It has not said where it is.');
        if (robot) this.fetchMessages();
    }

    showFacts(facts) {
        const list = byId('robot-facts');
        if (this.facts.size !== facts.length) {
            this.facts = new Map(facts.map(([name]) => [name, make('dd', {})]));
            list.replaceChildren(...[...this.facts].flatMap(([name, value]) => [make('dt', {}, name), value]));
        }
        for (const [name, text] of facts) put(this.facts.get(name), text);
    }

    async fetchMessages() {
        const now = performance.now();
        if (now - this.fetchedAt < fetchEveryMs) return;
        this.fetchedAt = now;
        const id = this.id;
        try {
            const answer = await fetch('/api/robots/' + id);
            if (!answer.ok || id !== this.id) return;
            this.showMessages((await answer.json()).messages);
        } catch {
            // The page says by itself that the server is gone.
        }
    }

    showMessages(messages) {
        const key = (m) => `${m.unix_ms} ${m.times} ${m.topic} ${m.text}`;
        const list = byId('messages');
        const newest = messages.slice().reverse();
        if (newest.length > 0 && list.dataset.newest === key(newest[0]) && list.children.length > 0) return;
        list.dataset.newest = newest.length > 0 ? key(newest[0]) : '';
        list.replaceChildren(...newest.map((message) => {
            const direction = message.to_robot ? 'is told' : 'says';
            const words = message.text + (message.times > 1 ? ` (${message.times} times)` : '');
            return make('li', {class: message.to_robot ? 'to' : 'from'}, make('time', {}, clock(message.unix_ms)),
                        make('span', {class: 'direction'}, direction),
                        make('span', {class: 'topic mono'}, message.topic), make('span', {class: 'words mono'}, words));
        }));
        put(byId('messages-hint'), newest.length > 0 ? '' :
            'Nothing yet: what has its id in its topic, and heartbeats, are shown here.');
    }
}

export const isRobotId = (text) => /^[0-9a-f]{8}$/.test(shown(text));
