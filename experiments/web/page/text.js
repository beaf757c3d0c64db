// Texts of the network are shown as text, never as markup; what cannot be seen in them, or turns
// the text around it, is shown by a sign or its number.

const unseen = /[\u0080-\u009f\u00ad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb]/g;

export function shown(text) {
    return String(text)
        .replace(/[\u0000-\u001f]/g, (c) => String.fromCharCode(0x2400 + c.charCodeAt(0)))
        .replace(/\u007f/g, '\u2421')
        .replace(unseen, (c) => '\\u' + c.charCodeAt(0).toString(16).padStart(4, '0'));
}

/** Changes the node's text, if it is another one. */
export function put(node, text) {
    const next = shown(text);
    const inner = node.firstChild;
    if (inner instanceof Text && node.lastChild === inner) {
        if (inner.data !== next) inner.data = next;
    } else if (node.textContent !== next) {
        node.textContent = next;
    }
}

/** An element with attributes, and texts and elements in it. */
export function make(tag, attributes = {}, ...children) {
    const node = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
        if (value !== undefined) node.setAttribute(name, value);
    }
    for (const child of children) {
        node.append(child instanceof Node ? child : shown(child));
    }
    return node;
}

export const byId = (id) => document.getElementById(id);

export function number(value) {
    if (value >= 10000) return Math.round(value / 1000) + 'k';
    return value >= 10 || Number.isInteger(value) ? String(Math.round(value)) : value.toFixed(1);
}

export function octets(perSecond) {
    if (perSecond < 1000) return perSecond + ' B/s';
    if (perSecond < 1e6) return (perSecond / 1000).toFixed(1) + ' kB/s';
    return (perSecond / 1e6).toFixed(1) + ' MB/s';
}

export function milliseconds(ms) {
    if (ms < 10) return ms.toFixed(1) + ' ms';
    if (ms < 1000) return Math.round(ms) + ' ms';
    if (ms < 60000) return (ms / 1000).toFixed(1) + ' s';
    return age(ms);
}

export function age(ms) {
    const s = Math.max(0, Math.floor(ms / 1000));
    if (s < 60) return s + ' s';
    if (s < 3600) return Math.floor(s / 60) + ' min';
    if (s < 172800) return Math.floor(s / 3600) + ' h';
    return Math.floor(s / 86400) + ' days';
}

export function clock(unixMs) {
    const time = new Date(unixMs);
    const two = (n) => String(n).padStart(2, '0');
    return `${two(time.getHours())}:${two(time.getMinutes())}:${two(time.getSeconds())}`;
}

export function count(n, one, many = one + 's') {
    return `${n} ${n === 1 ? one : many}`;
}
