// SPDX-License-Identifier: BSD-3-Clause
// Draws the newest snapshot ten times a second, and marks what is old; sends the acts.
"use strict";

const RETRY = 1000; // [ms] before a connection that was refused is tried again
const SILENT = 3000; // [ms] without news, or that they are late, after which the connection is made anew
const DRIFT = 2e-4; // [-] by which two clocks run apart, at most
const STOP_WITHIN = 4000; // [ms] for a stop to be answered
const ACT_WITHIN = 9000; // [ms] for any other act; the server gives up a second later
const READ_WITHIN = 500; // [ms] after a question came, in which a press was meant for what stood there before
const PICKED_FOR = 6000; // [ms] that a click into the picture stays marked
const MANY = 10; // words, above which they are drawn smaller
const QUIET = -60, LOUD = -3; // [dB] ends of the level bar, and what clips
const SHAPES = { standby: "circle", active: "disc", moving: "arrow", stopping: "bars", halted: "square", faulted: "warning" };
const NAMES = {
  standby: "Standby", active: "Ready", moving: "Moving", stopping: "Stopping", halted: "Halted", faulted: "Fault", // states
  stop: "Stop", fault: "Fault", refusal: "Refusal", low: "low", medium: "medium", high: "high", // alarms
};
const ALARM_SHAPES = { stop: "square", fault: "warning", refusal: "cross" };
const PRIORITIES = ["", "low", "medium", "high"];
const PHASES = {
  reach: "Reaching the tissue", close: "Closing the jaws", pull: "Pulling", step: "One step", open: "Opening the jaws", ease: "Easing off",
  approach: "Approaching the trocar", align: "Aligning the tool", insert: "Inserting", withdraw: "Withdrawing", look: "Moving the camera",
  brake: "Braking", hold: "Holding",
};

const byId = (id) => document.getElementById(id);
const say = (id, text) => { const e = byId(id); if (e.textContent !== text) e.textContent = text; };
const show = (id, isShown) => { byId(id).hidden = !isShown; };
const shape = (id, name) => byId(id).setAttribute("href", `#${name}`);
const mm = (metres, digits) => `${(1000 * metres).toFixed(digits)} mm`;

// Gives `work` a signal that ends in time [ms] what it fetches; AbortSignal.timeout came in 2022 only.
async function inTime(within, work, givesWay = true) {
  const control = new AbortController();
  const timer = setTimeout(() => control.abort(), within);
  if (givesWay) underWay.add(control);
  try { return await work(control.signal); } finally { clearTimeout(timer); underWay.delete(control); }
}

// A browser has six connections to a server, and a stop needs one: what else is fetched gives way, in other windows too.
const underWay = new Set();
const windows = "BroadcastChannel" in window ? new BroadcastChannel("stop") : null;
const giveWay = () => { for (const control of underWay) control.abort(); };
if (windows) windows.onmessage = giveWay;

// Uses the browser's storage, which a person may have blocked: then nothing is kept.
function stored(use) {
  try { return use(); } catch (error) { return null; }
}

let news = null; // the newest snapshot
let arrived = -Infinity; // [ms] when it would have come without delay on the way
let fastest = Infinity; // [ms] from the server's clock to this one's, with the least delay since the connection was made
let heard = 0; // [ms] when it came
let taken = -Infinity; // [ms] when the picture that is shown came from the camera
let source = null;
let token = "";
let tried = performance.now(); // [ms] when a connection was tried last

// --- news

function connect() {
  if (source) source.close();
  if (document.hidden) return; // its connection is left to others
  tried = performance.now();
  source = new EventSource("/events");
  source.onopen = () => { // perhaps of another server, whose clock and pictures begin anew
    fastest = Infinity;
    delete byId("picture").dataset.number;
  };
  source.onmessage = (event) => {
    const now = performance.now();
    news = JSON.parse(event.data);
    fastest = Math.min(now - 1000 * news.steady, fastest + DRIFT * (now - heard));
    heard = now;
    arrived = fastest + 1000 * news.steady; // what comes late is as old as it is late
    draw();
  };
  source.onerror = () => { // a browser tries again by itself, unless it was refused
    if (source.readyState === EventSource.CLOSED) setTimeout(connect, RETRY);
  };
}

function draw() {
  const since = (performance.now() - arrived) / 1000;
  const limit = news ? news.old_after : 0.5;
  const isLost = since > limit;
  show("lost", isLost);
  document.title = isLost ? t`No connection` : title(since, limit);
  if (isLost) say("lost-words", news ? t` for ${since.toFixed(0)} s: nothing below is as it is now` : t` yet`);
  tell("lost", isLost ? t`No connection to the robot's display` : news ? t`Connected` : "");
  if (news) {
    drawRobot(since, limit);
    drawHearing(since, limit);
    drawTissue(since, limit);
    drawPicture();
    drawAlarm();
    drawFoot(since, limit);
  }
  if (unsaid.length) say("announce", unsaid.splice(0).join(". "));
}

const ageOf = (part, since) => part && part.age !== null ? part.age + since : Infinity; // [s]

// Marks a part as old, in words; returns whether it can be drawn.
function mark(id, part, since, limit, what) {
  const age = ageOf(part, since), isOld = age > limit;
  const words = age === Infinity ? t`No news of the ${what}` : t`Old: ${what} silent for ${age < 10 ? age.toFixed(1) : age.toFixed(0)} s`;
  byId(id).classList.toggle("is-old", isOld);
  byId(id).dataset.old = isOld ? words : "";
  tell(id, isOld ? t`No news of the ${what}` : t`News of the ${what}`, !isOld);
  return Boolean(part);
}

function title(since, limit) {
  const robot = news.robot;
  return `${ageOf(robot, since) > limit ? t`No news` : word(NAMES[robot.state] || robot.state)} - ${t`Theatre`}`;
}

function drawRobot(since, limit) {
  const robot = news.robot;
  if (!mark("robot", robot, since, limit, t`controller`)) return;
  byId("robot").dataset.state = robot.state;
  forgetStop(robot.state);
  const name = word(NAMES[robot.state] || robot.state);
  say("state", name);
  shape("state-shape", SHAPES[robot.state] || "clock");
  const held = robot.is_tissue_held ? t`tissue held` : t`nothing held`;
  say("why", robot.halt_reason || (robot.state === "standby" ? t`${held}; say “${robot.words[0] || "hey robot"}” to begin` : held));
  const isUnderWay = robot.state === "moving" || robot.state === "stopping";
  const phase = word(PHASES[robot.phase] || robot.phase);
  say("phase", isUnderWay ? [robot.command, phase].filter(Boolean).join(": ") : robot.command ? t`Last: ${robot.command}` : t`At rest`);
  say("remaining", isUnderWay && robot.remaining !== null ? t`about ${robot.remaining.toFixed(1)} s` : "");
  bar("progress", isUnderWay ? robot.progress : 0, Math.round(100 * robot.progress), `${phase}, ${Math.round(100 * robot.progress)} %`);
  const words = robot.words.join("|");
  if (byId("words").dataset.words !== words) {
    byId("words").dataset.words = words;
    byId("words").classList.toggle("is-many", robot.words.length > MANY);
    const texts = robot.words.map((word) => word.replace(/\{\w+\}/, "…")); // any amount of that kind
    byId("words").textContent = ""; // replaceChildren came in 2020 only
    byId("words").append(...texts.map((textContent) => Object.assign(document.createElement("b"), { textContent })));
  }
  tell("state", `${name}. ${isUnderWay ? phase : robot.halt_reason}`);
}

function drawHearing(since, limit) {
  const hearing = news.hearing;
  if (!mark("hearing", hearing, since, limit, t`voice`)) return;
  say("microphone", hearing.microphone || t`not named`);
  const share = Math.min(1, Math.max(0, (hearing.level - QUIET) / -QUIET));
  bar("level", share, Math.max(QUIET, hearing.level).toFixed(0), `${hearing.level.toFixed(0)} decibel`);
  byId("level").classList.toggle("is-loud", hearing.level > LOUD);
  say("level-number", `${hearing.level.toFixed(0)} dB`);
  say("level-words", hearing.trouble || (hearing.level > LOUD ? t`Too loud: it clips` : t`Voice ${word(hearing.mode || "unknown")}`));
  say("partial", hearing.partial ? t`hearing “${hearing.partial}” ?` : "");
  drawUtterance(hearing.utterance, hearing.device);
  drawQuestion(hearing.question);
}

function drawQuestion(question) {
  show("question", Boolean(question));
  show("partial", !question);
  if (!question) { setAnswering(false); delete byId("question").dataset.command; return; }
  const shown = byId("question").dataset;
  if (shown.command !== question.command) { shown.command = question.command; asked = performance.now(); }
  say("question-words", t`${question.command}? Yes within ${Math.ceil(question.remaining)} s`);
  tell("question", t`${question.command}? Say or press yes`);
}

function drawUtterance(said, device) {
  show("utterance", Boolean(said));
  if (!said) { say("utterance-why", t`Nothing has been said yet`); return; }
  const isTaken = Boolean(said.command);
  byId("utterance").classList.toggle("is-taken", isTaken);
  byId("utterance").classList.toggle("is-refused", !isTaken);
  shape("utterance-shape", isTaken ? "tick" : "cross");
  const text = said.transcript.trim();
  say("utterance-words", isTaken ? said.command : text ? `“${text}”` : t`no words`);
  const ago = said.age < 1.5 ? t`now` : said.age < 90 ? t`${said.age.toFixed(0)} s ago` : t`${(said.age / 60).toFixed(0)} min ago`;
  const by = said.decided_by === "spotter" ? t`, by the spotter` : "";
  const why = isTaken ? `${t`taken from “${text}”`}${by}` : t`not taken: ${said.reason}`;
  say("utterance-why", device || `${why}, ${ago}`);
  if (device) tell("device", device);
  tell("utterance", isTaken ? t`Heard ${said.command}` : `${text}. ${t`not taken: ${said.reason}`}`);
}

function drawTissue(since, limit) {
  const tissue = news.tissue;
  if (!mark("tissue", tissue, since, limit, t`measurements`)) return;
  const top = 1.1 * (tissue.tension_limit || 2);
  const tension = tissue.invalid_reason ? null : tissue.tension;
  say("tension", tension === null ? t`no value` : `${tension.toFixed(2)} N`);
  bar("tension-bar", (tension || 0) / top, (tension || 0).toFixed(2), tension === null ? t`no value` : `${tension.toFixed(2)} newton`);
  byId("tension-bar").setAttribute("aria-valuemax", top.toFixed(2));
  byId("tension-bar").parentElement.classList.toggle("is-over", Boolean(tissue.tension_limit) && tension > tissue.tension_limit);
  place("target-mark", tissue.tension_target, top);
  place("limit-mark", tissue.tension_limit, top);
  say("tension-target", tissue.invalid_reason ? t`Not valid: ${tissue.invalid_reason}` : tissue.tension_target === null ? t`no target` : t`target ${tissue.tension_target.toFixed(2)} N`);
  say("tension-limit", tissue.tension_limit === null ? "" : t`limit ${`${tissue.tension_limit.toFixed(2)} N`}`);
  const isOutside = tissue.insertion !== null && tissue.insertion < 0;
  const error = tissue.rcm_error, bound = tissue.rcm_limit;
  say("rcm", error === null ? t`no value` : error < 0.01 ? mm(error, 3) : mm(error, 1));
  bar("rcm-bar", bound && error !== null ? error / (1.1 * bound) : 0, error === null ? 0 : (1000 * error).toFixed(3), error === null ? t`no value` : mm(error, 3));
  byId("rcm-bar").setAttribute("aria-valuemax", bound ? (1100 * bound).toFixed(2) : 1);
  byId("rcm-bar").parentElement.classList.toggle("is-over", !isOutside && Boolean(bound) && error > bound);
  say("rcm-limit", isOutside ? t`outside: no limit` : bound === null ? "" : t`limit ${mm(bound, 2)}`);
  say("depth", tissue.insertion === null ? "" : isOutside ? t`${mm(-tissue.insertion, 0)} outside` : t`depth ${mm(tissue.insertion, 0)}`);
}

function drawPicture() {
  const picture = news.picture, image = byId("picture"), frame = byId("picture-frame");
  if (picture && image.dataset.number !== String(picture.number) && !image.dataset.loading) {
    image.dataset.loading = "yes"; // one at a time
    const done = () => { delete image.dataset.loading; };
    loadPicture(image, picture, arrived - 1000 * picture.age).then(done, () => setTimeout(done, RETRY));
  }
  if (!picture) image.hidden = true; // it was another server's
  const isShown = !image.hidden, isOld = isShown && isPictureOld();
  const age = pictureAge().toFixed(1), words = isOld ? t`OLD picture, ${age} s ago` : t`Picture, ${age} s ago`;
  show("pick", isShown);
  say("picture-words", isShown ? words : t`No picture of the scene`);
  frame.classList.toggle("is-old", isOld);
  frame.dataset.old = isOld ? words : "";
}

// With its stamp, by which a click names the picture that it was made into.
async function loadPicture(image, picture, came) {
  const next = new Image();
  const stamp = await inTime(ACT_WITHIN, async (signal) => {
    const answer = await fetch("/picture", { signal });
    if (!answer.ok) throw new Error(answer.statusText);
    next.src = URL.createObjectURL(await answer.blob());
    return answer.headers.get("Picture-Stamp");
  });
  await next.decode().catch((error) => { URL.revokeObjectURL(next.src); throw error; }); // before it is shown: no flicker
  URL.revokeObjectURL(image.src);
  image.src = next.src;
  Object.assign(image.dataset, { number: picture.number, stamp });
  image.hidden = false;
  taken = came;
}

const pictureAge = () => (performance.now() - taken) / 1000; // [s]
const isPictureOld = () => !news.picture || pictureAge() > 2 * news.picture.period + news.old_after;

function drawAlarm() {
  const alarm = news.alarm;
  const isShown = !alarm || ["stop", "fault", "refusal"].includes(alarm.kind); // notices would make the page jump
  show("alarm", isShown);
  if (!alarm) {
    say("alarm-cause", t`No alarms are watched`);
    say("alarm-next", t`Start the alarm node, or watch the log`);
    say("alarm-others", "");
    drawHeadline({ kind: "fault", priority: 2, is_acknowledged: false });
  } else if (isShown) {
    drawHeadline(alarm);
    say("alarm-cause", alarm.cause);
    say("alarm-next", alarm.next_step ? t`Next: ${alarm.next_step}` : "");
    say("alarm-others", alarm.others.length ? t`also: ${alarm.others.join("; ")}` : "");
  }
  const words = alarm && isShown ? `${headline(alarm)}: ${alarm.cause}. ${alarm.next_step}` : "";
  if (words !== said.alarm) { said.alarm = words; say("alert", words); }
  tell("acknowledged", alarm && isShown && alarm.is_acknowledged ? t`acknowledged` : "");
}

// Kind and priority, as the terminal has them.
const headline = ({ kind, priority }) =>
  [word(NAMES[kind]), "!".repeat(priority), word(PRIORITIES[priority])].filter(Boolean).join(" ");

function drawHeadline(alarm) {
  const band = byId("alarm");
  Object.assign(band.dataset, { kind: alarm.kind, priority: alarm.priority });
  band.classList.toggle("is-acknowledged", alarm.is_acknowledged);
  shape("alarm-shape", ALARM_SHAPES[alarm.kind]);
  say("alarm-kind", headline(alarm));
  say("alarm-acknowledged", alarm.is_acknowledged ? t`acknowledged` : "");
}

function drawFoot(since, limit) {
  const recording = news.recording;
  const isOld = !recording || recording.age + since > Math.max(2, limit);
  const isOn = !isOld && !recording.problem;
  byId("recording").classList.toggle("is-on", isOn);
  byId("recording").classList.toggle("is-off", !isOn);
  shape("recording-shape", isOn ? "disc" : "cross");
  const file = recording && recording.file ? recording.file.split("/").slice(-2, -1)[0] : "";
  const took = recording && recording.since !== null ? duration(recording.since) : "";
  say("recording-words", isOn ? t`Recording ${`${took} ${file}`}` : recording ? (isOld ? t`Recorder silent` : t`Not recorded: ${recording.problem}`) : t`Not recorded`);
  say("disk", recording && recording.free !== null ? t`${(recording.free / 1e9).toFixed(1)} GB free` : "");
  say("time", new Date(1000 * news.time).toLocaleTimeString("en-GB"));
}

function duration(seconds) {
  const whole = Math.floor(seconds);
  const two = (n) => String(n).padStart(2, "0");
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

function bar(id, share, value, words) {
  const element = byId(id);
  element.querySelector(".fill").style.setProperty("--share", Math.min(1, Math.max(0, share)).toFixed(3));
  element.setAttribute("aria-valuenow", value);
  element.setAttribute("aria-valuetext", words);
}

function place(id, value, top) {
  show(id, value !== null && value !== undefined);
  if (value) byId(id).style.setProperty("--share", Math.min(1, value / top).toFixed(3));
}

// Tells screen readers each change of a part once; the first news of all parts say nothing.
// What one drawing finds is said at once at its end: of several texts in a row they read the last.
const said = { alarm: "" }, unsaid = [];
function tell(part, words, isFirstQuiet = false) {
  if (said[part] === words) return;
  const isFirst = said[part] === undefined;
  said[part] = words;
  if (words && !(isFirst && isFirstQuiet)) unsaid.push(words);
}

// --- acts

// Gives whether it was done, and in which words; null: nobody knows.
async function act(name, fields, words, within = ACT_WITHIN) {
  const body = fields ? JSON.stringify(fields) : undefined;
  const headers = fields ? { "Content-Type": "application/json", Authorization: `Bearer ${token}` } : {};
  try {
    return await inTime(within, async (signal) => {
      const response = await fetch(`/act/${name}`, { method: "POST", body, headers, signal });
      if (!response.ok) {
        if (response.status === 401) lock();
        return words(false, (await response.text()).trim());
      }
      const outcome = await response.json();
      return words(outcome.done, outcome.words);
    }, name !== "stop");
  } catch (error) {
    return words(null, t`no answer`);
  }
}

let pressed = -Infinity; // [ms]
let presses = 0; // of STOP
let isStopOpen = false; // the last press has no answer yet
let hasRested = false; // the robot was seen halted after that answer
function stop() {
  if (performance.now() - pressed < 300) return; // a press is also a click
  pressed = performance.now();
  const press = ++presses;
  isStopOpen = true;
  stopWords(true, t`Stop is sent`);
  giveWay();
  if (windows) windows.postMessage("");
  act("stop", null, (isDone, text) => {
    if (press !== presses) return; // a later press has its own answer
    isStopOpen = hasRested = false;
    stopWords(isDone, isDone ? text : t`NOT STOPPED: ${text}. Press the emergency stop.`);
  }, STOP_WITHIN);
}

const stopRest = () => stopWords(true, t`Brakes and holds. Not an emergency stop.`);

// What came of a stop is no longer true of a robot that halted and was woken since.
function forgetStop(state) {
  if (isStopOpen || !presses) return;
  if (state === "halted" || state === "faulted") hasRested = true;
  else if (hasRested && (state === "active" || state === "moving")) { hasRested = false; stopRest(); }
}

function stopWords(isDone, text) {
  say("stop-words", text);
  byId("stop-words").classList.toggle("is-bad", !isDone);
}

function actWords(isDone, text) {
  if (!isDone) byId("more").open = true;
  say("act-words", text);
}

function lock() {
  token = "";
  stored(() => sessionStorage.removeItem("token"));
}

function needToken() {
  if (!token) { say("act-words", t`Enter the token first: it is printed where the page was started`); byId("more").open = true; }
  return !token;
}

byId("stop").addEventListener("pointerdown", stop);
byId("stop").addEventListener("click", stop);
byId("unlock").addEventListener("submit", (event) => {
  event.preventDefault();
  const entered = byId("token").value.trim();
  if (/[^ -~]/.test(entered)) { say("act-words", t`A token has the letters A to Z and digits only: this one is not taken`); return; } // no header holds it
  token = entered;
  stored(() => sessionStorage.setItem("token", token));
  byId("token").value = "";
  say("act-words", token ? t`The token is kept until this page is closed` : "");
  if (token) byId("more").open = false; // it covers what lies above
});
byId("choose").addEventListener("click", () => {
  const name = byId("microphone-name").value.trim();
  if (name && !needToken()) act("microphone", { name }, actWords);
});
byId("theme").addEventListener("change", (event) => theme(event.target.value));

let asked = -Infinity; // [ms] when the question that is shown came
// A question takes one answer; it can be given again only where it was not taken.
function setAnswering(isAnswering) {
  for (const answer of ["yes", "no"]) byId(answer).disabled = isAnswering;
}
for (const answer of ["yes", "no"]) {
  byId(answer).addEventListener("pointerdown", () => { byId(answer).dataset.command = byId("question").dataset.command; });
  byId(answer).addEventListener("click", (event) => {
    const command = byId("question").dataset.command, isByKey = event.detail === 0;
    if (needToken()) return;
    const isRead = performance.now() - asked >= READ_WITHIN && (isByKey || byId(answer).dataset.command === command);
    if (answer === "yes" && !isRead) { actWords(false, t`The question has just changed: read it, then press again`); return; }
    setAnswering(true);
    act("answer", { command, yes: answer === "yes" }, (isDone, text) => {
      if (!isDone) setAnswering(false);
      actWords(isDone, text);
    });
  });
}

// One press arms one click into the picture, so that nothing is chosen by chance.
function arm(isArmed) {
  byId("pick").setAttribute("aria-pressed", String(isArmed));
  byId("picture-frame").classList.toggle("is-armed", isArmed);
}
byId("pick").addEventListener("click", () => {
  const isArmed = byId("pick").getAttribute("aria-pressed") !== "true";
  if (isArmed && needToken()) return;
  arm(isArmed);
  say("pick-words", isArmed ? t`Click the tissue in the endoscope's picture` : "");
});
let unmark = 0; // timer that ends the mark of the last click
function markPick(event) {
  const frame = byId("picture-frame").getBoundingClientRect(), picked = byId("picked");
  picked.style.left = `${event.clientX - frame.left}px`;
  picked.style.top = `${event.clientY - frame.top}px`;
  picked.hidden = false;
  clearTimeout(unmark); // of an earlier click
  unmark = setTimeout(() => { picked.hidden = true; }, PICKED_FOR);
}
byId("picture").addEventListener("click", (event) => {
  if (byId("pick").getAttribute("aria-pressed") !== "true") return;
  if (isPictureOld()) { say("pick-words", t`That picture is old: wait for a new one, then click again`); return; }
  arm(false);
  const box = byId("picture").getBoundingClientRect();
  const x = (event.clientX - box.left) / box.width, y = (event.clientY - box.top) / box.height;
  markPick(event);
  say("pick-words", t`Asking the controller`);
  act("grasp", { x, y, stamp: Number(byId("picture").dataset.stamp) }, (isDone, text) => say("pick-words", isDone ? t`Set: ${text}` : isDone === null ? t`Perhaps set: ${text}` : t`Not set: ${text}`));
});

function theme(name) {
  stored(() => localStorage.setItem("theme", name));
  if (name) document.documentElement.dataset.theme = name;
  else delete document.documentElement.dataset.theme;
}

byId("theme").value = stored(() => localStorage.getItem("theme")) || "";
theme(byId("theme").value);
token = stored(() => sessionStorage.getItem("token")) || "";

document.addEventListener("visibilitychange", connect);
translate().then(() => { if (!presses) stopRest(); });
connect();
setInterval(() => {
  if (performance.now() - Math.max(tried, arrived) > SILENT) connect();
  if (performance.now() - arrived > 150) draw(); // what was drawn last gets older
}, 100);
