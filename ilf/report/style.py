"""How the page looks: light and dark, from 360 pixels on, and on paper."""

STYLE = """
:root { color-scheme: light dark; --ground: #fff; --ink: #1c2126; --soft: #5c6670; --line: #d9dde2; --card: #f5f6f8;
  --accent: #1b5fa8; --warn: #b3541e; }
@media screen and (prefers-color-scheme: dark) { :root { --ground: #14171b; --ink: #e4e7ea; --soft: #9aa4ae;
  --line: #323840; --card: #1c2127; --accent: #7ab4f0; --warn: #f0a060; } }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body { margin: 0; background: var(--ground); color: var(--ink);
  font: 15px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; }
main, footer { max-width: 88rem; margin: 0 auto; padding: 0 clamp(.9rem, 3vw, 2.5rem); }
article { padding-top: 1.2rem; }
article + article { margin-top: 3rem; border-top: 3px solid var(--line); }
h1 { font-size: clamp(1.4rem, 4vw, 2rem); line-height: 1.2; margin: .6rem 0 .4rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; line-height: 1.25; margin: 2.2rem 0 .8rem; }
h3 { font-size: .95rem; margin: 0 0 .4rem; }
p { margin: .5rem 0; max-width: 50rem; overflow-wrap: anywhere; }
a { color: var(--accent); }
.back { margin: 0; font-size: .87rem; }
.lead { white-space: pre-line; border-left: 3px solid var(--accent); padding-left: .8rem; }
.warning { border-left: 3px solid var(--warn); padding-left: .8rem; }
dl { display: grid; grid-template-columns: fit-content(38%) minmax(0, 1fr); gap: .25rem 1.2rem;
  margin: .6rem 0; }
dt { color: var(--soft); } dd { margin: 0; overflow-wrap: anywhere; }
.hash { font: .8rem/1.6 ui-monospace, "Cascadia Mono", Menlo, Consolas, monospace; color: var(--soft); }
pre { background: var(--card); border: 1px solid var(--line); border-radius: 6px; padding: .7rem .9rem; margin: .6rem 0;
  white-space: pre-wrap; overflow-wrap: anywhere; font-size: .85rem; }
.wide { overflow-x: auto; margin: .6rem 0 1rem; }
table { border-collapse: collapse; font-size: .87rem; line-height: 1.35; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .35rem .9rem .35rem 0; border-bottom: 1px solid var(--line); }
th { color: var(--soft); font-weight: 600; vertical-align: bottom; border-bottom-width: 2px; }
th:last-child, td:last-child { padding-right: 0; }
td { overflow-wrap: anywhere; max-width: 22rem; }
td:not(.n) { min-width: 7rem; }
.key { position: sticky; left: 0; background: var(--ground); }
@media (max-width: 40rem) { .key { max-width: 9.5rem; } }
.n { text-align: right; white-space: nowrap; overflow-wrap: normal; }
th.n { white-space: normal; }
td img { display: block; width: 7.5rem; height: auto; border-radius: 3px; }
.plate { display: inline-block; width: .8em; height: .8em; border-radius: 2px; margin-right: .45em;
  vertical-align: -.05em; border: 1px solid #0003; }
.pictures, .plots { display: grid; gap: 1.6rem 1.4rem; margin: .6rem 0;
  grid-template-columns: repeat(auto-fill, minmax(min(100%, 24rem), 1fr)); }
.plots { grid-template-columns: repeat(auto-fill, minmax(min(100%, 30rem), 1fr)); }
figure { margin: 0; min-width: 0; }
figcaption { font-size: .85rem; color: var(--soft); } figcaption p { margin: .25rem 0 0; }
.picture { position: relative; line-height: 0; border-radius: 4px; overflow: hidden; }
.picture img { width: 100%; height: auto; }
.picture b { position: absolute; transform: translate(-50%, -50%); font: 700 10.5px/1 system-ui, sans-serif;
  color: #fff; text-shadow: 0 0 2px #000, 0 0 2px #000, 0 0 3px #000; }
.bar { margin-top: .4rem; }
.bar img { display: block; width: 100%; height: 9px; border-radius: 2px; }
.bar div { display: flex; justify-content: space-between; font-size: .8rem; color: var(--soft); line-height: 1.4; }
.scale { margin-top: .3rem; font-size: .8rem; color: var(--soft); line-height: 1.3; }
.scale i { display: block; height: 6px; border: 2px solid var(--ink); border-top: 0; }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: .1rem 1.1rem; margin: .35rem 0 0; padding: 0;
  font-size: .82rem; color: var(--soft); }
.legend li { overflow-wrap: anywhere; } .legend svg { margin-right: .45em; vertical-align: .1em; }
.plots > figure > svg { display: block; width: 100%; height: auto; }
svg text.ink { fill: var(--soft); } svg line.ink { stroke: var(--soft); } svg .grid { stroke: var(--line); }
footer { margin-top: 3rem; padding-top: 1rem; padding-bottom: 2rem; font-size: .85rem; color: var(--soft); }
@page { size: A4; margin: 15mm 13mm; }
@media print {
  body { font-size: 10pt; }
  main, footer { max-width: none; padding: 0; }
  .plate, .scale i, .bar img { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  article { padding-top: 0; }
  article + article { break-before: page; border-top: 0; margin-top: 0; }
  h1, h2, h3, p:has(+ .plots), p:has(+ .wide) { break-after: avoid; }
  h2 { margin-top: 1.4rem; }
  figure, tr, dl > *, pre { break-inside: avoid; }
  .pictures, .plots { grid-template-columns: repeat(2, 1fr); gap: 1rem; }
  .wide { overflow: visible; }
  table { font-size: 7.8pt; } th, td { padding: .18rem .45rem .18rem 0; } td { min-width: 0; }
  td img { width: 22mm; }
  pre { font-size: 8pt; } .hash { font-size: 7.5pt; }
  .back { display: none; } footer { margin-top: 1rem; padding: 0; }
}
"""
