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
    }

    /** Draws these robots; tells how many of them have a place. */
    draw(model, robots) {
        const placed = robots.filter((robot) => robot.place);
        const parent = this.canvas.parentElement;
        if (parent.hidden !== (placed.length === 0)) parent.hidden = placed.length === 0;
        if (placed.length === 0) return 0;
        const box = {width: parent.clientWidth, height: parent.clientHeight};
        if (box.width === 0 || box.height === 0) return placed.length;
        const style = getComputedStyle(this.canvas);
        const colours = new Map();
        for (const {home} of placed) {
            if (!colours.has(home)) colours.set(home, style.getPropertyValue('--home-' + model.colourOf(home)));
        }
        const before = this.frame;
        this.fit(placed, box);
        if (this.frame !== before || performance.now() >= this.pathsDueAt) {
            this.pathsDueAt = performance.now() + pathsEveryMs;
            const pen = blank(this.under, box);
            this.drawGrid(pen, box, style);
            const points = placed.reduce((sum, robot) => sum + robot.path.length, 0);
            const stride = Math.ceil(points / mostPathPoints);
            for (const robot of placed) this.drawPath(pen, robot, colours.get(robot.home), stride);
        }
        const pen = blank(this.canvas, box);
        this.spots = placed.map((robot) => this.drawRobot(pen, robot, colours.get(robot.home)));
        if (placed.length <= 40) this.drawNames(pen, placed, style);
        return placed.length;
    }

    fit(placed, box) {
        let [left, right, bottom, top] = [Infinity, -Infinity, Infinity, -Infinity];
        const take = (x, y) => {
            left = Math.min(left, x);
            right = Math.max(right, x);
            bottom = Math.min(bottom, y);
            top = Math.max(top, y);
        };
        for (const robot of placed) {
            take(robot.place.x_mm, robot.place.y_mm);
            for (const [x, y] of robot.path) take(x, y);
        }
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

    drawGrid(pen, box, style) {
        const {pxPerMm} = this.frame;
        const steps = [100, 200, 500, 1e3, 2e3, 5e3, 1e4, 2e4, 5e4, 1e5, 1e6, 1e7, 1e8, 1e9];
        const step = steps.find((mm) => mm * pxPerMm >= 48) ?? 1e10;
        const xs = [-box.width / 2, box.width / 2].map((px) => this.frame.x + px / pxPerMm);
        const ys = [-box.height / 2, box.height / 2].map((px) => this.frame.y + px / pxPerMm);
        pen.strokeStyle = style.getPropertyValue('--line');
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
        pen.fillStyle = pen.strokeStyle = style.getPropertyValue('--muted');
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

    drawRobot(pen, robot, colour) {
        const [x, y] = this.at(robot.place.x_mm, robot.place.y_mm);
        pen.save();
        pen.translate(x, y);
        pen.rotate(-robot.place.heading_mdeg / 1000 * Math.PI / 180);
        pen.fillStyle = colour;
        pen.globalAlpha = robot.state === 'connected' ? 1 : 0.4;
        pen.beginPath();
        pen.moveTo(9, 0);
        pen.lineTo(-6, 6);
        pen.lineTo(-3, 0);
        pen.lineTo(-6, -6);
        pen.closePath();
        pen.fill();
        pen.restore();
        return {x, y, robot: robot.robot};
    }

    drawNames(pen, placed, style) {
        pen.font = '11px ui-monospace, monospace';
        pen.fillStyle = style.getPropertyValue('--ink');
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
