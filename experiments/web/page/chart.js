// A line over the last five minutes, with the deaths of brokers marked in it.

import {make, put} from './text.js';

const svgNamespace = 'http://www.w3.org/2000/svg';
const spanMs = 300000;
const height = 120;
const inset = {left: 48, right: 10, top: 8, bottom: 20};

function draw(tag, attributes, text) {
    const node = document.createElementNS(svgNamespace, tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    if (text !== undefined) node.textContent = text;
    return node;
}

/** A number that is easily halved and read: the least that is not under the value. */
function roundUp(value) {
    const power = 10 ** Math.floor(Math.log10(Math.max(value, 1e-3)));
    return [1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].map((n) => n * power).find((n) => n >= value * 0.999);
}

export class Chart {
    /** lines: [{key, class}], the first one is the figure that is told. */
    constructor(figure, {title, lines, least, text}) {
        this.lines = lines;
        this.least = least;
        this.text = text;
        this.now = make('b', {});
        this.note = make('span', {class: 'note'});
        this.svg = draw('svg', {role: 'img', height});
        this.title = title;
        figure.append(make('figcaption', {}, make('span', {}, title), this.note, this.now), this.svg);
        this.svg.addEventListener('pointermove', (event) => this.point(event));
        this.svg.addEventListener('pointerleave', () => {
            this.pointed = undefined;
            this.caption();
        });
    }

    show(seconds, deaths, now) {
        this.seconds = seconds;
        this.width = this.svg.parentElement.clientWidth;
        if (this.width === 0) return;
        this.end = now;
        const values = seconds.flatMap((s) => this.lines.map((line) => s[line.key] ?? 0));
        this.most = roundUp(Math.max(this.least, ...values));
        const parts = [...this.gridParts(), ...this.deathParts(deaths), ...this.lostParts()];
        for (const line of this.lines) parts.push(...this.lineParts(line));
        this.cursor = draw('line', {class: 'cursor', y1: inset.top, y2: height - inset.bottom, visibility: 'hidden'});
        this.svg.setAttribute('viewBox', `0 0 ${this.width} ${height}`);
        this.svg.replaceChildren(...parts, this.cursor);
        this.caption();
        const told = seconds.map((s) => s[this.lines[0].key]).filter((v) => v !== undefined);
        this.svg.setAttribute('aria-label', told.length === 0 ? `${this.title}: nothing yet`
            : `${this.title}: now ${this.text(told[told.length - 1])}; in the last five minutes from ` +
              `${this.text(Math.min(...told))} to ${this.text(Math.max(...told))}`);
    }

    x(unixMs) {
        const inner = this.width - inset.left - inset.right;
        return inset.left + inner * (1 - (this.end - unixMs) / spanMs);
    }

    y(value) {
        return height - inset.bottom - (height - inset.top - inset.bottom) * value / this.most;
    }

    gridParts() {
        const parts = [];
        for (const share of [0, 0.5, 1]) {
            const y = Math.round(this.y(this.most * share)) + 0.5;
            parts.push(draw('line', {class: 'grid', x1: inset.left, x2: this.width - inset.right, y1: y, y2: y}));
            parts.push(draw('text', {x: inset.left - 6, y: y + 4, 'text-anchor': 'end'}, this.text(this.most * share, true)));
        }
        for (const minutes of [4, 3, 2, 1]) {
            const x = this.x(this.end - minutes * 60000);
            parts.push(draw('text', {x, y: height - 4, 'text-anchor': 'middle'}, `−${minutes} min`));
        }
        return parts;
    }

    deathParts(deaths) {
        return deaths.filter((death) => this.end - death.unix_ms < spanMs).map((death) => {
            const x = this.x(death.unix_ms);
            return draw('line', {class: 'death', x1: x, x2: x, y1: inset.top, y2: height - inset.bottom});
        });
    }

    lostParts() {
        if (this.lines[0].key === 'messages') return [];
        return this.seconds.filter((s) => s.echoes_lost > 0 && this.end - s.unix_ms < spanMs).map((s) =>
            draw('rect', {class: 'lost', x: this.x(s.unix_ms) - 1, y: height - inset.bottom - 6, width: 2, height: 6}));
    }

    lineParts(line) {
        let path = '';
        let isDrawing = false;
        for (const second of this.seconds) {
            const value = second[line.key];
            if (value === undefined || this.end - second.unix_ms > spanMs) {
                isDrawing = false;
                continue;
            }
            path += `${isDrawing ? 'L' : 'M'}${this.x(second.unix_ms).toFixed(1)} ${this.y(value).toFixed(1)}`;
            isDrawing = true;
        }
        return [draw('path', {class: line.class, d: path})];
    }

    point(event) {
        const x = event.clientX - this.svg.getBoundingClientRect().left;
        let nearest;
        for (const second of this.seconds ?? []) {
            const distance = Math.abs(this.x(second.unix_ms) - x);
            if (distance < (nearest?.distance ?? 12)) nearest = {distance, second};
        }
        this.pointed = nearest?.second;
        this.caption();
    }

    caption() {
        const second = this.pointed ?? this.seconds?.[this.seconds.length - 1];
        const value = second?.[this.lines[0].key];
        put(this.now, value === undefined ? '–' : this.text(value));
        const ago = second ? Math.round((this.end - second.unix_ms) / 1000) : 0;
        const notes = [];
        if (this.pointed) notes.push(`${ago} s ago`);
        const worst = second && this.lines[1] ? second[this.lines[1].key] : undefined;
        if (worst !== undefined) notes.push(`at most ${this.text(worst)}`);
        if (second?.echoes_lost && this.lines[1]) notes.push(`${second.echoes_lost} lost`);
        put(this.note, notes.join(', '));
        if (!this.cursor) return;
        this.cursor.setAttribute('visibility', this.pointed ? 'visible' : 'hidden');
        if (this.pointed) {
            this.cursor.setAttribute('x1', this.x(this.pointed.unix_ms));
            this.cursor.setAttribute('x2', this.x(this.pointed.unix_ms));
        }
    }
}
