// The bar of a recording: play, pause, speed, and any place of it.

import {byId, clock, milliseconds, put} from './text.js';

const speeds = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];

export class RecordingBar {
    constructor() {
        this.playing = byId('play');
        this.speed = byId('speed');
        this.place = byId('place');
        for (const speed of speeds) this.speed.append(new Option(`${speed} ×`, speed));
        this.playing.addEventListener('click', () => this.ask({play: !this.recording.is_playing}));
        this.speed.addEventListener('change', () => this.ask({speed: Number(this.speed.value)}));
        this.place.addEventListener('input', () => this.tell(Number(this.place.value)));
        this.place.addEventListener('change', () => this.ask({at_unix_ms: Number(this.place.value)}));
        // Who holds the handle is not pulled away from where he is.
        for (const [begins, ends] of [['pointerdown', 'pointerup'], ['keydown', 'keyup']]) {
            this.place.addEventListener(begins, () => (this.isHeld = true));
            this.place.addEventListener(ends, () => (this.isHeld = false));
        }
        this.place.addEventListener('blur', () => (this.isHeld = false));
    }

    show(model) {
        this.recording = model.recording;
        document.body.classList.toggle('is-recording', this.recording !== undefined);
        byId('recording').hidden = this.recording === undefined;
        if (this.recording === undefined) return;
        const {file, start_unix_ms, end_unix_ms, speed, is_playing, lost} = this.recording;
        put(byId('recording-file'), file);
        put(this.playing, is_playing ? 'Pause' : 'Play');
        if (document.activeElement !== this.speed) this.speed.value = String(speed);
        this.place.min = start_unix_ms;
        this.place.max = end_unix_ms;
        put(byId('recording-lost'), lost.join('. '));
        if (this.isHeld) return;
        const at = Math.min(model.now(), end_unix_ms);
        this.place.value = at;
        this.tell(at);
    }

    tell(at) {
        const {start_unix_ms, end_unix_ms, is_seeking} = this.recording;
        const text = `${clock(at)}, ${milliseconds(at - start_unix_ms)} of ${milliseconds(end_unix_ms - start_unix_ms)}` +
            (is_seeking ? ', on the way' : '');
        put(byId('place-text'), text);
        if (this.place.ariaValueText !== text) this.place.ariaValueText = text;
    }

    async ask(wish) {
        try {
            const answer = await fetch('/api/recording', {
                method: 'POST', headers: {'Content-Type': 'application/json'}, body: JSON.stringify(wish),
            });
            put(byId('recording-said'), answer.ok ? '' : 'Refused: ' + (await answer.json()).error);
        } catch {
            put(byId('recording-said'), 'romano web does not answer.');
        }
    }
}
