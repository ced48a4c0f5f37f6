// The style of the page of `compare`: on wide and narrow screens, light and dark, and on paper.
#pragma once

namespace psplit {

inline constexpr const char* kPageStyle = R"(
:root { color-scheme: light dark; --page: #fff; --text: #1b1f24; --faint: #57606a; --rule: #d5dae0; --shade: #f4f6f8;
  --edge: #0006; }
.s0 { --c: #1c2026 } .s1 { --c: #b5540a } .s2 { --c: #0b4a9a } .s3 { --c: #1fa380 } .s4 { --c: #a826f0 }
@media screen and (prefers-color-scheme: dark) {
  :root { --page: #14171a; --text: #e6e9ec; --faint: #a3adb8; --rule: #343b43; --shade: #1d2227; --edge: #fff6; }
  .s0 { --c: #eee8fa } .s1 { --c: #c98a2e } .s2 { --c: #5a86ff } .s3 { --c: #43e6a0 } .s4 { --c: #dc3f92 }
}
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.25rem 4rem; max-width: 92rem; background: var(--page); color: var(--text);
  font: 16px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 0 0 .25rem; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin: 2.5rem 0 .75rem; }
a { color: inherit; }
p { max-width: 50rem; margin: 0 0 .75rem; overflow-wrap: anywhere; }
.headline { font-size: 1.35rem; line-height: 1.35; font-weight: 600; margin-top: 1.25rem; }
.noise { max-width: 50rem; margin: 1.25rem 0; padding: .75rem 1rem; background: var(--shade); border-left: 4px solid var(--faint); }
.noise h2 { font-size: 1rem; margin: 0 0 .5rem; } .noise p:last-child { margin: 0; }
.method { columns: 2 30rem; column-gap: 2.5rem; } .method p { break-inside: avoid; }
.lead, .rule, figcaption small { color: var(--faint); }
.pair { display: grid; gap: 1.5rem 2.5rem; grid-template-columns: repeat(auto-fit, minmax(min(100%, 30rem), 1fr)); }
figure { margin: 0; min-width: 0; }
figcaption { font-weight: 600; margin-bottom: .25rem; }
figcaption small { display: block; font-weight: 400; }
.picture { text-align: center; }
.picture img { display: block; max-width: 100%; height: auto; margin: 0 auto; }
dl { display: grid; grid-template-columns: max-content minmax(0, 1fr); gap: .2rem 1rem; margin: 0; align-content: start; }
dt { color: var(--faint); } dd { margin: 0; overflow-wrap: anywhere; }
.words { max-width: 60rem; } dfn { font-style: normal; font-weight: 600; color: var(--text); }
code { font: .9em ui-monospace, monospace; }
.legend { display: flex; flex-wrap: wrap; gap: .1rem 1rem; list-style: none; margin: 0; padding: 0; font-size: .9rem; }
.legend svg { vertical-align: -2px; margin-right: .4rem; }
/* Wide content scrolls. A shadow marks the side with more content, and a line above says that it scrolls. */
.scroll { overflow-x: auto; background:
  linear-gradient(90deg, var(--page) 40%, transparent) 0 0 / 2.5rem 100% no-repeat local,
  linear-gradient(270deg, var(--page) 40%, transparent) 100% 0 / 2.5rem 100% no-repeat local,
  linear-gradient(90deg, var(--edge), transparent) 0 0 / .8rem 100% no-repeat scroll,
  linear-gradient(270deg, var(--edge), transparent) 100% 0 / .8rem 100% no-repeat scroll; }
.hint { display: none; color: var(--faint); font-size: .85rem; margin: 0 0 .25rem; }
@media screen and (max-width: 68rem) { .wide-hint { display: block; } }
/* Charts shrink with the window; narrow windows show the narrow drawings, whose letters are as large. */
#size-speed { margin-top: 1.5rem; }
.plot svg { display: block; max-width: 100%; height: auto; } .plot .narrow { display: none; }
.plot text { font: 13px system-ui, sans-serif; fill: var(--text); font-variant-numeric: tabular-nums; }
.plot text.title, .plot text.tick { fill: var(--faint); }
.plot text.tag { font-size: 12px; font-weight: 600; paint-order: stroke; stroke: var(--page); stroke-width: 3px; }
.grid { stroke: var(--rule); } .axis { stroke: var(--faint); }
.reference { stroke: var(--text); stroke-dasharray: 5 4; }
.front { fill: none; stroke: var(--faint); stroke-width: 1.5; stroke-dasharray: 2 3; }
.ring { fill: none; stroke: var(--text); stroke-dasharray: 3 2; }
.mark, .key { fill: var(--c); stroke: var(--page); } .mark:hover { stroke: var(--text); stroke-width: 2; }
.hollow { fill: var(--page); stroke: var(--c); stroke-width: 2; }
.noisy { fill-opacity: .45; stroke: var(--text); stroke-dasharray: 3 2; }
.line { fill: none; stroke: var(--c); stroke-width: 1.5; } .dashed { stroke-dasharray: 6 3; }
.spread { stroke: var(--c); stroke-width: 3; opacity: .4; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
caption, .caption { color: var(--faint); font-size: .9rem; margin: 1.25rem 0 .4rem; }
th, td { padding: .25rem .7rem; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--rule); }
th:first-child, td:first-child, .left { text-align: left; padding-left: .4rem; }
thead th { vertical-align: bottom; white-space: normal; } tbody th { font-weight: 600; }
tbody tr:hover { background: var(--shade); }
@media screen and (max-width: 40rem) {
  .hint { display: block; }
  body { padding: 1rem 1rem 3rem; } h1 { font-size: 1.4rem; } .headline { font-size: 1.15rem; }
  .plot .wide { display: none; } .plot .narrow { display: block; width: 100%; max-width: 26rem; }
  dl { display: block; } dd { margin-bottom: .4rem; }
  th:first-child { position: sticky; left: 0; background: var(--page); min-width: 7rem; max-width: 8rem; white-space: normal; }
}
@media print {
  @page { margin: 12mm; }
  body { max-width: none; padding: 0; font-size: 10pt; }
  p, .noise, .words { max-width: none; } .caption { font-size: 9pt; } .headline { font-size: 13pt; } h2 { margin: 1.25rem 0 .5rem; }
  .pair { gap: 1rem 1.5rem; grid-template-columns: 1fr 1fr; }
  .pair .wide { display: none; } .pair .narrow { display: block; width: 100%; }
  h1, h2, .caption, figcaption { break-after: avoid; } h1, h2, .caption, .whole, figure, tr, dt, dd { break-inside: avoid; }
  thead { display: table-header-group; }
  #setting .pair { display: block; } .picture { margin-top: 1rem; } .picture img { max-height: 6cm; width: auto; }
  .scroll { overflow: visible; background: none; }
  table { width: 100%; font-size: 7.5pt; } th, td { padding: 1.5pt 3pt; }
  th:first-child, td:first-child, .left { white-space: normal; padding-left: 0; }
}
)";

}  // namespace psplit
