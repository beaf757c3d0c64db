// Robots seen from above: where they are, where they look, the path behind them. What it shows
// stands in the table of robots as text too.

import {make, shown} from './text.js';

const margin = 28;

/** The canvas in the size of its box, with nothing on it. */
function blank(canvas, box) {
    const scale = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(box.width * scale), Math.round(box.height * scale)];
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    const pen = canvas.getContext('2d');
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, box.width, box.height);
    return pen;
}

/** The colours of the style sheet: asked for once, for each question makes the browser look at all styles anew. */
class Colours {
    constructor(canvas) {
        this.style = getComputedStyle(canvas);
        this.known = new Map();
    }

    of(name) {
        if (!this.known.has(name)) this.known.set(name, this.style.getPropertyValue(name));
        return this.known.get(name);
    }
}

/** What holds all points that it is told. */
class Extent {
    constructor(other) {
        [this.left, this.right, this.bottom, this.top] =
            other ? [other.left, other.right, other.bottom, other.top] : [Infinity, -Infinity, Infinity, -Infinity];
    }

    take(x, y) {
        if (x < this.left) this.left = x;
        if (x > this.right) this.right = x;
        if (y < this.bottom) this.bottom = y;
        if (y > this.top) this.top = y;
    }
}

// Paths are many lines and change slowly; robots are few and are drawn at each change, on a canvas above them.
const pathsEveryMs = 1000;
const mostPathPoints = 3000;  // then only some of each robot's, so that a frame has time for them

export class FleetMap {
    constructor(canvas) {
        this.canvas = canvas;
        this.under = make('canvas', {'aria-hidden': 'true'});
        canvas.before(this.under);
        this.clear();
    }

    clear() {
        this.spots = [];
        this.frame = null;
        this.pathsDueAt = 0;
        this.walked = new Extent();  // of all paths, when they were drawn last
        this.colours = new Colours(this.canvas);
    }

    /** Draws these robots; tells how many of them have a place. */
    draw(model, robots) {
        const placed = robots.filter((robot) => robot.place);
        const parent = this.canvas.parentElement;
        if (parent.hidden !== (placed.length === 0)) parent.hidden = placed.length === 0;
        if (placed.length === 0) return 0;
        const box = {width: parent.clientWidth, height: parent.clientHeight};
        if (box.width === 0 || box.height === 0) return placed.length;
        const {colours} = this;
        const colourOf = (robot) => colours.of('--home-' + model.colourOf(robot.home));
        const arePathsDue = performance.now() >= this.pathsDueAt;
        if (arePathsDue) {
            this.walked = new Extent();
            for (const robot of placed) for (const [x, y] of robot.path) this.walked.take(x, y);
        }
        const before = this.frame;
        this.fit(placed, box);
        if (this.frame !== before || arePathsDue) {
            this.pathsDueAt = performance.now() + pathsEveryMs;
            const pen = blank(this.under, box);
            this.drawGrid(pen, box, colours);
            const points = placed.reduce((sum, robot) => sum + robot.path.length, 0);
            const stride = Math.ceil(points / mostPathPoints);
            for (const robot of placed) this.drawPath(pen, robot, colourOf(robot), stride);
        }
        const pen = blank(this.canvas, box);
        this.drawRobots(pen, placed, colourOf);
        if (placed.length <= 40) this.drawNames(pen, placed, colours);
        return placed.length;
    }

    fit(placed, box) {
        const all = new Extent(this.walked);
        for (const {place} of placed) all.take(place.x_mm, place.y_mm);
        const {left, right, bottom, top} = all;
        const least = 1000;  // mm: robots that stand still are not shown as if through a lens
        const wide = Math.max(right - left, least);
        const high = Math.max(top - bottom, least);
        const pxPerMm = Math.min((box.width - 2 * margin) / wide, (box.height - 2 * margin) / high);
        const before = this.frame;
        const fits = before && before.width === box.width && pxPerMm <= before.pxPerMm * 2 &&
            left >= before.left && right <= before.right && bottom >= before.bottom && top <= before.top;
        if (fits) return;  // a map that moves with each step is hard to read
        const [x, y] = [(left + right) / 2, (bottom + top) / 2];
        const roomy = pxPerMm / 1.15;
        const [w, h] = [(box.width - 2 * margin) / roomy / 2, (box.height - 2 * margin) / roomy / 2];
        this.frame = {width: box.width, height: box.height, pxPerMm: roomy, x, y,
                      left: x - w, right: x + w, bottom: y - h, top: y + h};
    }

    at(x, y) {
        const {width, height, pxPerMm} = this.frame;
        return [width / 2 + (x - this.frame.x) * pxPerMm, height / 2 - (y - this.frame.y) * pxPerMm];
    }

    drawGrid(pen, box, colours) {
        const {pxPerMm} = this.frame;
        const steps = [100, 200, 500, 1e3, 2e3, 5e3, 1e4, 2e4, 5e4, 1e5, 1e6, 1e7, 1e8, 1e9];
        const step = steps.find((mm) => mm * pxPerMm >= 48) ?? 1e10;
        const xs = [-box.width / 2, box.width / 2].map((px) => this.frame.x + px / pxPerMm);
        const ys = [-box.height / 2, box.height / 2].map((px) => this.frame.y + px / pxPerMm);
        pen.strokeStyle = colours.of('--line');
        pen.lineWidth = 1;
        pen.beginPath();
        for (let x = Math.ceil(xs[0] / step) * step; x <= xs[1]; x += step) {
            const px = Math.round(this.at(x, 0)[0]) + 0.5;
            pen.moveTo(px, 0);
            pen.lineTo(px, box.height);
        }
        for (let y = Math.ceil(ys[0] / step) * step; y <= ys[1]; y += step) {
            const px = Math.round(this.at(0, y)[1]) + 0.5;
            pen.moveTo(0, px);
            pen.lineTo(box.width, px);
        }
        pen.stroke();
        pen.fillStyle = pen.strokeStyle = colours.of('--muted');
        pen.font = '12px system-ui, sans-serif';
        const px = step * pxPerMm;
        pen.beginPath();
        pen.moveTo(10.5, box.height - 14);
        pen.lineTo(10.5, box.height - 10);
        pen.lineTo(10.5 + px, box.height - 10);
        pen.lineTo(10.5 + px, box.height - 14);
        pen.stroke();
        pen.fillText(step >= 1000 ? step / 1000 + ' m' : step / 10 + ' cm', 14, box.height - 16);
    }

    drawPath(pen, robot, colour, stride) {
        if (robot.path.length < 2) return;
        pen.strokeStyle = colour;
        pen.globalAlpha = 0.4;
        pen.lineWidth = stride > 1 ? 1 : 2;
        pen.lineJoin = 'bevel';
        pen.beginPath();
        for (let at = robot.path.length - 1; at >= 0; at -= stride) pen.lineTo(...this.at(...robot.path[at]));
        pen.stroke();
        pen.globalAlpha = 1;
    }

    /** All of one colour at once: a thousand small shapes take longer than one with a thousand parts. */
    drawRobots(pen, placed, colourOf) {
        const alike = new Map();
        for (const robot of placed) {
            const alpha = robot.state === 'connected' ? 1 : 0.4;
            const look = alpha + colourOf(robot);
            if (!alike.has(look)) alike.set(look, {alpha, colour: colourOf(robot), robots: []});
            alike.get(look).robots.push(robot);
        }
        for (const {alpha, colour, robots} of alike.values()) {
            pen.globalAlpha = alpha;
            pen.fillStyle = colour;
            pen.beginPath();
            for (const robot of robots) this.addArrow(pen, robot.place);
            pen.fill();
        }
        pen.globalAlpha = 1;
        this.spots = placed.map((robot) => {
            const [x, y] = this.at(robot.place.x_mm, robot.place.y_mm);
            return {x, y, robot: robot.robot};
        });
    }

    addArrow(pen, place) {
        const [x, y] = this.at(place.x_mm, place.y_mm);
        const heading = place.heading_mdeg / 1000 * Math.PI / 180;
        const [along, across] = [Math.cos(heading), Math.sin(heading)];
        const to = (ahead, right) => [x + ahead * along + right * across, y - ahead * across + right * along];
        pen.moveTo(...to(9, 0));
        pen.lineTo(...to(-6, 6));
        pen.lineTo(...to(-3, 0));
        pen.lineTo(...to(-6, -6));
    }

    drawNames(pen, placed, colours) {
        pen.font = '11px ui-monospace, monospace';
        pen.fillStyle = colours.of('--ink');
        placed.forEach((robot, at) => {
            const {x, y} = this.spots[at];
            pen.fillText(shown(robot.robot), x + 11, y + 4);
        });
    }

    /** The robot at this point of the canvas; none within a finger's breadth: undefined. */
    robotAt(x, y) {
        let [found, nearest] = [undefined, 22];
        for (const spot of this.spots) {
            const distance = Math.hypot(spot.x - x, spot.y - y);
            if (distance < nearest) [found, nearest] = [spot.robot, distance];
        }
        return found;
    }
}
