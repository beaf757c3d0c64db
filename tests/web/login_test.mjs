// The page behind a token in a real Chromium: `node login_test.mjs URL TOKEN`. It says in a line what it saw; what is not so
// ends it with exit code 1 and a sentence.

import {createRequire} from 'node:module';
import assert from 'node:assert/strict';

const {chromium} = createRequire(process.env.PAGE_TEST_MODULES + '/')('playwright-core');
const [url, token] = process.argv.slice(2);
const say = (line) => process.stdout.write(line + '\n');
const isRoot = process.getuid() === 0;

const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: isRoot ? ['--no-sandbox'] : [],
});
// The test's certificate vouches for itself.
const open = async (more) => {
    const context = await browser.newContext({ignoreHTTPSErrors: true, ...more});
    const page = await context.newPage();
    page.setDefaultTimeout(20000);
    return page;
};

const stranger = await open({httpCredentials: {username: 'anna', password: 'something-else'}});
assert.equal((await stranger.goto(url)).status(), 401);
say('without the token nothing is shown');

const page = await open({httpCredentials: {username: 'anna', password: token}});
assert.equal((await page.goto(url)).status(), 200);
await page.locator('#brokers li').first().waitFor();  // told by the stream of events
say('with it the fleet is shown');

page.on('dialog', (dialog) => dialog.accept());
const answer = page.waitForResponse('**/api/stop');
await page.locator('#stop-all').click();
assert.equal((await answer).status(), 202);
say('all are told to stop');
await browser.close();
