// The page in a real Chromium: `node page_test.mjs URL ROBOT HOSTILE_CLIENT`. It looks, and says in a line what it saw; who
// started it kills a broker when it has said where the robot's home is, and the server in the end. What is not so ends it with
// exit code 1 and a sentence.

import {createRequire} from 'node:module';
import assert from 'node:assert/strict';

const {chromium} = createRequire(process.env.PAGE_TEST_MODULES + '/')('playwright-core');
const [url, robot, hostile] = process.argv.slice(2);
const say = (line) => process.stdout.write(line + '\n');
const isRoot = process.getuid() === 0;
const shotFolder = process.env.PAGE_TEST_SHOTS;  // where pictures of the page are wanted

const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: isRoot ? ['--no-sandbox'] : [],
});
const page = await browser.newPage({viewport: {width: 1280, height: 900}});
page.setDefaultTimeout(20000);
const complaints = [];
page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
page.on('pageerror', (error) => complaints.push(error.message));
page.on('dialog', (dialog) => {
    complaints.push('a script of the network ran: ' + dialog.message());
    dialog.dismiss();
});
const requested = [];
page.on('request', (request) => requested.push(request.url()));

const row = page.locator('#robots tr', {hasText: robot});
const home = row.locator('[data-column=Home]');
const text = (selector) => page.locator(selector).innerText();
/** The page draws what it is told in its next frame. */
const becomes = (selector, hasText) => page.locator(selector, {hasText}).first().waitFor({state: 'attached'});
const areRobotsListed = (count) => page.waitForFunction((all) => document.querySelectorAll('#robots tr').length === all, count);
const shoot = (name) => shotFolder && page.screenshot({path: `${shotFolder}/${name}.png`, fullPage: true});

async function theFleetIsShown() {
    await page.goto(url);
    await row.waitFor();
    await becomes('#summary', /3 brokers · r\d leads/);
    assert.equal(await page.locator('#brokers li').count(), 3);
    assert.equal(await page.locator('#brokers dd', {hasText: /^\d+ % of a core$/}).count(), 3, 'the load of each');
    assert.equal(await page.locator('#brokers dd', {hasText: /^100 of 100$/}).count(), 3, 'the condition of each');
    await page.locator('#topics tr', {hasText: /robots of r2robots\/\{id\}\/posewho subscribed/}).waitFor();
    await page.locator('#map-hint:empty').waitFor({state: 'attached'});  // so it has places to show
    await page.locator('#chart-delay svg[aria-label^="Delay of an echo: now"]').waitFor({state: 'attached'});
    say('the fleet is shown');
}

async function hostileNamesAreText() {
    await page.goto(`${url}#/robots/${hostile}`);
    await page.locator('#robot-facts dd', {hasText: '<img src=x onerror=alert(1)>'}).waitFor();
    await page.locator('#messages li', {hasText: '<script>alert(2)</script>'}).waitFor();
    await page.locator('#messages li', {hasText: '(60000 octets)'}).nth(1).waitFor();  // a name and a text
    const words = await text('#messages');
    assert.ok(words.includes('\u241b[31m'), 'a control character is shown as a sign: ' + words);
    assert.ok(!/[\u0000-\u0009\u000b-\u001f\u202e]/.test(words), 'none is left as it was');
    assert.equal(await page.locator('main img, main script, main iframe').count(), 0);
    say('hostile names are text');
}

async function itFitsAPhone() {
    for (const [width, scheme] of [[390, 'light'], [390, 'dark'], [1280, 'dark']]) {
        await page.setViewportSize({width, height: 844});
        await page.emulateMedia({colorScheme: scheme});
        for (const hash of ['', `#/robots/${hostile}`, `#/robots/${robot}`]) {
            await page.goto(url + hash);
            await page.waitForTimeout(300);  // its events come, and a frame
            const wide = await page.evaluate(() => document.documentElement.scrollWidth);
            assert.ok(wide <= width, `${hash || 'the fleet'} is ${wide} px wide at ${width}`);
            const small = await page.evaluate(() => [...document.querySelectorAll('a, button, input, select')]
                .filter((node) => node.checkVisibility() && node.getBoundingClientRect().height < 24).map((node) => node.outerHTML));
            assert.deepEqual(small, [], 'a finger hits everything');
            await shoot(`${hash.slice(-8) || 'fleet'}-${width}-${scheme}`);
        }
    }
    const colour = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    assert.equal(colour, 'rgb(14, 17, 22)', 'dark is dark');
    say('it fits a phone');
}

async function aKeyboardIsEnough() {
    await page.goto(url);
    await row.waitFor();
    await page.keyboard.press('Tab');
    await page.keyboard.press('Tab');
    assert.equal(await page.evaluate(() => document.activeElement.id), 'stop-all');
    await page.keyboard.press('Enter');
    await page.locator('#stop-said', {hasText: /stop all, to \d+ robots\. The broker has/}).waitFor();
    await page.locator('#find').focus();
    await page.keyboard.type(robot);
    await areRobotsListed(1);
    await page.keyboard.press('Tab');
    await page.keyboard.press('Enter');
    await page.locator('#robot-title', {hasText: robot}).waitFor();
    await page.locator('#robot-title:focus').waitFor();  // so a reader hears where it is
    await page.locator('#amount').fill('70mm');
    await page.keyboard.press('Enter');
    await page.locator('#robot-said', {hasText: 'move front 70mm'}).waitFor();
    await page.locator('#amount').fill('70 parsecs');
    await page.keyboard.press('Enter');
    await page.locator('#robot-said', {hasText: 'Refused: amount'}).waitFor();
    complaints.splice(0);  // the browser itself complains of the answer 400
    await page.goBack();
    say('a keyboard is enough');
}

async function namesOfAScreenReaderAreThere() {
    const nameless = await page.evaluate(() => [...document.querySelectorAll('button, a, input, select, section, svg, canvas')]
        .filter((node) => !node.ariaHidden && !node.textContent.trim() && !node.ariaLabel && !node.labels?.length && !node.getAttribute('aria-labelledby'))
        .map((node) => node.outerHTML));
    assert.deepEqual(nameless, []);
    for (const live of ['#announcer[aria-live=polite]', '#alarm[role=alert]', '#stop-said[role=status]']) {
        assert.equal(await page.locator(live).count(), 1, live);
    }
    say('a screen reader is told');
}

async function aNewHomeIsShownWhenTheOldOneDies() {
    await page.setViewportSize({width: 390, height: 844});
    await page.goto(url);
    await row.waitFor();
    const before = await home.textContent();  // innerText of what is scrolled away is empty
    const isElsewhere = page.waitForFunction(([id, old]) => {
        const found = [...document.querySelectorAll('#robots tr')].find((tr) => tr.textContent.includes(id));
        const now = found?.querySelector('[data-column=Home]').textContent;
        return now && now !== old ? now : false;
    }, [robot, before], {polling: 'raf'});
    say(`home is ${before}`);
    say(`home is now ${await (await isElsewhere).jsonValue()}`);
    await page.locator('#time-line li[data-kind=take-over]', {hasText: `took over`}).waitFor();
    await page.locator('#brokers li.dead', {hasText: before}).waitFor();
    await becomes('#announcer', /died|took over|leads/);
    say('the time line tells of the take-over');
}

async function noServerIsSaid() {
    await page.locator('#alarm', {hasText: 'romano web does not answer'}).waitFor();
    say('the page says that it is alone');
}

try {
    await theFleetIsShown();
    await hostileNamesAreText();
    await itFitsAPhone();
    await aKeyboardIsEnough();
    await namesOfAScreenReaderAreThere();
    await aNewHomeIsShownWhenTheOldOneDies();
    assert.deepEqual(complaints, []);
    assert.deepEqual(requested.filter((one) => !one.startsWith(url)), [], 'nothing is fetched from elsewhere');
    await noServerIsSaid();
} catch (error) {
    process.stderr.write(`${error.message}\n${complaints.join('\n')}\n`);
    process.exitCode = 1;
}
await browser.close();
process.exit();
