// The fleet as the server tells it: first the whole, then what has changed.

const mostPlaces = 100;
const mostSeconds = 300;
const mostHappenings = 200;
const stepOfPathMm = 20;

export class Model {
    constructor() {
        this.clear();
    }

    clear() {
        this.brokers = new Map();
        this.colours = new Map();  // by the brokers' names
        this.robots = new Map();
        this.happenings = new Map();
        this.seconds = [];
        this.talks = [];
        this.watch = {is_linked: false};
        this.cluster = {leader: '', members: []};
        this.skewMs = 0;
        this.recording = undefined;
    }

    /** The server's clock, or the place in the recording. */
    now() {
        if (this.recording === undefined) return Date.now() + this.skewMs;
        const {at_unix_ms, speed, is_playing, is_seeking} = this.recording;
        if (!is_playing || is_seeking) return at_unix_ms;
        return at_unix_ms + (performance.now() - this.recordingToldAt) * speed;
    }

    setState(state) {
        this.clear();
        this.change(state);
    }

    /** The robots that are new, or have another home or state. */
    change(change) {
        this.watch = change.watch;
        this.cluster = change.cluster;
        this.recording = change.recording;
        this.recordingToldAt = performance.now();
        for (const broker of change.brokers) this.brokers.set(broker.name, broker);
        if (this.brokers.size !== this.colours.size) {
            this.colours = new Map([...this.brokers.keys()].sort().map((name, at) => [name, String(at % 8)]));
        }
        const urgent = [];
        for (const id of change.left ?? []) this.robots.delete(id);
        for (const robot of change.robots) {
            const before = this.robots.get(robot.robot);
            robot.path = robot.path ?? before?.path ?? [];
            if (robot.place) walk(robot.path, robot.place);
            if (before?.home !== robot.home || before?.state !== robot.state) urgent.push(robot.robot);
            this.robots.set(robot.robot, robot);
        }
        for (const happening of change.time_line) this.happenings.set(happening.number, happening);
        for (const number of this.happenings.keys()) {
            if (this.happenings.size <= mostHappenings) break;
            this.happenings.delete(number);
        }
        this.talks = change.talks ?? this.talks;
        this.seconds.push(...change.seconds);
        this.seconds.splice(0, Math.max(0, this.seconds.length - mostSeconds));
        if (change.seconds.length > 0) {
            this.skewMs = change.seconds[change.seconds.length - 1].unix_ms - Date.now();
        }
        return urgent;
    }

    /** Of each broker; homes that are no known broker count too. */
    robotsByHome() {
        const counts = new Map();
        for (const robot of this.robots.values()) {
            counts.set(robot.home, (counts.get(robot.home) ?? 0) + 1);
        }
        return counts;
    }

    /** A broker has the same colour as long as no broker comes that stands before it. */
    colourOf(home) {
        return this.colours.get(home) ?? 'none';
    }
}

function walk(path, place) {
    const last = path[path.length - 1];
    if (last && Math.hypot(last[0] - place.x_mm, last[1] - place.y_mm) < stepOfPathMm) return;
    path.push([place.x_mm, place.y_mm]);
    if (path.length > mostPlaces) path.shift();
}
