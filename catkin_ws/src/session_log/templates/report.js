// SPDX-License-Identifier: BSD-3-Clause
// The report without this script is whole; with it parts fold, utterances sound, the time axis zooms.
"use strict";

const parts = [...document.querySelectorAll("details.part")];
if (matchMedia("(max-width: 640px)").matches) parts.slice(1).forEach((part) => (part.open = false));
document.querySelectorAll("details.still").forEach((still) => (still.open = false));
addEventListener("beforeprint", () => parts.forEach((part) => (part.open = true)));

let sounding = null;
document.addEventListener("click", (event) => {
  const button = event.target.closest("button.hear");
  if (!button) return;
  if (sounding) sounding.pause();
  sounding = new Audio(button.dataset.sound);
  sounding.play();
});

document.querySelectorAll(".search").forEach((search) => {
  const field = search.querySelector("input"), count = search.querySelector("output");
  const rows = [...search.parentElement.querySelectorAll("tbody tr")];
  search.hidden = false;
  field.addEventListener("input", () => {
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    rows.forEach((row) => {
      const text = `${row.textContent} ${row.dataset.words || ""}`.toLowerCase();
      row.hidden = !words.every((word) => text.includes(word));
    });
    count.textContent = `${rows.filter((row) => !row.hidden).length} of ${rows.length}`;
  });
});

document.querySelectorAll(".zoom").forEach((box) => {
  const data = JSON.parse(box.querySelector("script").textContent);
  const canvas = box.querySelector("canvas"), pen = canvas.getContext("2d");
  const LEFT = 46, LANES = 4, LINE = 15, BAND = 22, CURVE = 56, LEAST = 0.5; // LEAST in seconds
  let from = 0, to = data.duration, width = 0;
  box.hidden = false;

  const x = (time) => LEFT + ((time - from) / (to - from)) * (width - LEFT);
  const timeAt = (px) => from + ((px - LEFT) / (width - LEFT)) * (to - from);

  function show(first, last) {
    const length = Math.min(Math.max(last - first, LEAST), data.duration);
    from = Math.min(Math.max(first, 0), data.duration - length);
    to = from + length;
    canvas.setAttribute("aria-valuenow", ((from + to) / 2).toFixed(1));
    canvas.setAttribute("aria-valuetext", `${from.toFixed(1)} to ${to.toFixed(1)} seconds`);
    draw();
  }
  function scale(factor, middle = (from + to) / 2) {
    show(middle - (middle - from) * factor, middle + (to - middle) * factor);
  }
  function bar(span, y, height) {
    const [start, end, word, color] = span;
    if (end < from || start > to) return;
    const left = Math.max(x(start), LEFT), right = Math.min(x(end), width);
    pen.fillStyle = color;
    pen.fillRect(left, y, Math.max(right - left, 1), height);
    if (word && right - left > pen.measureText(word).width + 6) {
      pen.fillStyle = ["moving", "halted", "faulted"].includes(word) ? "#fff" : "#1f2933";
      pen.fillText(word, left + 3, y + height / 2);
    }
  }
  function labels(bottom) {
    const free = Array(LANES).fill(LEFT);
    for (const [time, words, color] of data.marks) {
      if (time < from || time > to) continue;
      const size = pen.measureText(words).width, left = Math.min(x(time) + 3, width - size);
      const lane = free.findIndex((edge) => edge <= left);
      pen.fillStyle = color;
      const y = lane < 0 ? bottom - 4 : bottom - (lane + 1) * LINE;
      pen.fillRect(x(time), y, 1, bottom + 8 - y);
      if (lane < 0) continue;
      pen.fillText(words, left, y + 6);
      free[lane] = left + size + 6;
    }
  }
  function curve(track, y) {
    const [low, high] = extremes(track.value.filter((value) => value !== null));
    const at = (value) => y + CURVE - 4 - ((value - low) / (high - low || 1)) * (CURVE - 12);
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, y, width - LEFT, CURVE);
    pen.clip();
    pen.strokeStyle = "#0072b2";
    pen.beginPath();
    let isBroken = true; // where a value is no number
    track.time.forEach((time, k) => {
      const value = track.value[k], isFar = track.time[k + 1] < from || track.time[k - 1] > to;
      if (value !== null && !isFar) pen[isBroken ? "moveTo" : "lineTo"](x(time), at(value));
      isBroken = value === null || isFar;
    });
    pen.stroke();
    pen.restore();
    pen.fillStyle = "#616e7c";
    pen.fillText(`${track.name}, ${low.toFixed(1)} to ${high.toFixed(1)}`, LEFT + 2, y + 5);
  }
  function extremes(values) {
    return values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
  }
  function axis(y) {
    const wanted = (to - from) / Math.max((width - LEFT) / 80, 1);
    const power = 10 ** Math.floor(Math.log10(wanted));
    const step = power * [1, 2, 5, 10].find((n) => n * power >= wanted);
    pen.fillStyle = "#616e7c";
    for (let k = Math.ceil(from / step); k * step <= to; k++) {
      pen.fillRect(x(k * step), y, 1, 4);
      pen.fillText(`${+(k * step).toFixed(2)} s`, Math.min(x(k * step) + 2, width - 36), y + 10);
    }
  }
  function draw() {
    const curves = data.curves.filter((track) => track.time.length);
    const height = LANES * LINE + 20 + data.bands.length * BAND + curves.length * CURVE + 18;
    const ratio = devicePixelRatio || 1;
    width = canvas.clientWidth;
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    canvas.style.height = `${height}px`;
    pen.scale(ratio, ratio);
    pen.font = "12px system-ui, sans-serif";
    pen.textBaseline = "middle";
    let y = LANES * LINE;
    labels(y);
    data.speech.forEach((span) => bar(span, y + 4, 8));
    y += 18;
    for (const band of data.bands) {
      band.spans.forEach((span) => bar(span, y, BAND - 4));
      pen.fillStyle = "#616e7c";
      pen.fillText(band.name, 0, y + 9);
      y += BAND;
    }
    curves.forEach((track, k) => curve(track, y + k * CURVE));
    axis(y + curves.length * CURVE);
  }

  const fingers = new Map();
  let moved = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event.offsetX);
    moved = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    const before = fingers.get(event.pointerId), now = event.offsetX;
    const other = [...fingers].find(([id]) => id !== event.pointerId);
    moved += Math.abs(now - before);
    if (other) {
      const factor = Math.abs(before - other[1]) / Math.max(Math.abs(now - other[1]), 1);
      scale(Math.min(Math.max(factor, 0.5), 2), timeAt(other[1]));
    } else {
      const shift = timeAt(before) - timeAt(now);
      show(from + shift, to + shift);
    }
    fingers.set(event.pointerId, now);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  }
  canvas.addEventListener("click", (event) => moved < 5 && goTo(timeAt(event.offsetX)));
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.shiftKey) return; // the page scrolls
    event.preventDefault();
    scale(event.deltaY + event.deltaX > 0 ? 1.25 : 0.8, timeAt(event.offsetX));
  }, { passive: false });
  box.querySelectorAll("[data-scale]").forEach((button) => {
    button.addEventListener("click", () => scale(+button.dataset.scale));
  });

  const keys = {
    ArrowLeft: () => show(from - (to - from) / 10, to - (to - from) / 10),
    ArrowRight: () => show(from + (to - from) / 10, to + (to - from) / 10),
    "+": () => scale(0.5),
    "=": () => scale(0.5), // the key of + without shift
    "-": () => scale(2),
    Enter: () => goTo((from + to) / 2, (to - from) / 2),
  };
  canvas.addEventListener("keydown", (event) => {
    if (!keys[event.key] || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault(); // the page scrolls otherwise
    keys[event.key]();
  });

  // Between the rows of the tables and the time axis.
  const rows = [...document.querySelectorAll("tr[data-time]")];
  function goTo(time, reach = ((to - from) / (width - LEFT)) * 40) { // seconds
    const away = (row) => Math.abs(row.dataset.time - time);
    const row = rows.reduce((a, b) => (a && away(a) <= away(b) ? a : b), null);
    if (!row || away(row) > reach) return;
    row.closest("details").open = true;
    row.scrollIntoView({ block: "center" });
    row.querySelector(".at").focus({ preventScroll: true });
    row.classList.add("found");
    setTimeout(() => row.classList.remove("found"), 2000);
  }
  rows.forEach((row) => {
    const words = row.querySelector("td span"), button = document.createElement("button");
    button.className = "at";
    button.title = "show on the time axis";
    words.replaceWith(button);
    button.append(words);
    button.addEventListener("click", () => {
      show(row.dataset.time - 5, +row.dataset.time + 5);
      box.scrollIntoView({ block: "center" });
      canvas.focus({ preventScroll: true });
    });
  });
  new ResizeObserver(() => canvas.clientWidth !== width && draw()).observe(canvas);
  canvas.setAttribute("aria-valuemax", data.duration);
  show(from, to);
});
