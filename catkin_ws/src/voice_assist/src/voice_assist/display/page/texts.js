// SPDX-License-Identifier: BSD-3-Clause
// The page's own words in its language, by the English ones.
"use strict";

const NAMED = ["aria-label", "alt"]; // attributes that are read aloud

let texts = {};

const word = (english) => texts[english] || english;

// A text in the page's language; what stands in braces is filled in.
function t(parts, ...values) {
  const english = parts.reduce((text, part, i) => `${text}{${i - 1}}${part}`);
  return word(english).replace(/\{(\d)\}/g, (_, i) => values[i]);
}

// Puts what stands in the page into its language, once; where that cannot be read it stays English.
async function translate() {
  try {
    const found = await (await fetch("/texts.json")).json();
    texts = found.texts;
    document.documentElement.lang = found.language;
  } catch (error) {
    return;
  }
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const english = walker.currentNode.data.trim();
    if (texts[english]) walker.currentNode.data = walker.currentNode.data.replace(english, texts[english]);
  }
  for (const name of NAMED) {
    for (const e of document.querySelectorAll(`[${name}]`)) e.setAttribute(name, word(e.getAttribute(name)));
  }
}
