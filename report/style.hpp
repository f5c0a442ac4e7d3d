#pragma once

#include <string_view>

namespace livermark::report {

/// How a report looks, on a screen of any width and on paper. Fonts are those of the reader's machine.
inline constexpr std::string_view style_sheet = R"(
:root { --ink: #1d2329; --soft: #56606a; --line: #d5dade; --paper: #ffffff; --tint: #f5f7f8; --accent: #0b5c7d;
  --hair: #e8ebed; --warm: #fbf7ec; --track: #eceff1; color-scheme: light dark; }
* { box-sizing: border-box; }
html { background: var(--paper); color: var(--ink); -webkit-text-size-adjust: 100%; }
body { margin: 0; font: 1.0625rem/1.55 Charter, "Bitstream Charter", "Source Serif Pro", Cambria, Georgia, serif; }
main { max-width: 66rem; margin: 0 auto; padding: 3rem 1.5rem 5rem; counter-reset: figure table; }
h1, h2, h3, table, svg, code, nav, .facts, figcaption { font-family: "Source Sans 3", "Source Sans Pro", "Helvetica Neue",
  "Segoe UI", Roboto, "Liberation Sans", Arial, sans-serif; }
h1 { font-size: 2.5rem; line-height: 1.15; font-weight: 600; letter-spacing: -0.015em; margin: 0 0 0.4rem; }
h2 { font-size: 1.6rem; line-height: 1.25; font-weight: 600; margin: 4rem 0 0.8rem; padding-top: 1rem;
  border-top: 1px solid var(--line); }
h3 { font-size: 1.15rem; font-weight: 600; margin: 2.2rem 0 0.5rem; }
p, ul, dl { max-width: 44rem; margin: 0 0 0.9rem; }
ul { padding-left: 1.2rem; }
a { color: var(--accent); text-decoration-thickness: 1px; text-underline-offset: 2px; }
.lead { font-size: 1.15rem; color: var(--soft); margin-bottom: 1.5rem; }
nav { columns: 3 14rem; font-size: 0.95rem; margin: 1.5rem 0 0; }
nav a { display: block; text-decoration: none; padding: 0.15rem 0; }
.facts { display: grid; grid-template-columns: max-content 1fr; gap: 0.2rem 1.2rem; font-size: 0.92rem;
  max-width: none; }
.facts dt { color: var(--soft); }
.facts dd { margin: 0; overflow-wrap: anywhere; }
.missing { border-left: 3px solid #b98a2f; background: var(--warm); padding: 0.6rem 0.9rem; font-size: 0.97rem; }
figure { margin: 1.6rem 0 2.2rem; }
figcaption { font-size: 0.92rem; line-height: 1.45; color: var(--soft); max-width: 50rem; margin-top: 0.6rem; }
figcaption::before { font-weight: 600; color: var(--ink); }
.figure { counter-increment: figure; }
.figure figcaption::before { content: "Figure " counter(figure) ". "; }
.table { counter-increment: table; }
.table figcaption::before { content: "Table " counter(table) ". "; }
.made { display: block; margin-top: 0.3rem; }
code { font-family: "JetBrains Mono", "DejaVu Sans Mono", Menlo, Consolas, monospace; font-size: 0.8em;
  background: var(--tint); padding: 0.08em 0.3em; border-radius: 3px; overflow-wrap: anywhere; }
.made code { display: block; padding: 0.3em 0.6em; margin-top: 0.25rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.86rem; line-height: 1.35; font-variant-numeric: tabular-nums lining-nums; }
th, td { text-align: left; vertical-align: baseline; padding: 0.26rem 0.75rem 0.26rem 0; border-bottom: 1px solid var(--hair); }
th { vertical-align: bottom; font-weight: 600; color: var(--soft); border-bottom: 1.5px solid var(--ink); }
.number { text-align: right; padding: 0.26rem 0 0.26rem 0.75rem; }
td.number, td:first-child { white-space: nowrap; }
td.number + td:not(.number), th.number + th:not(.number) { padding-left: 1rem; }
tbody tr:last-child td { border-bottom: 1.5px solid var(--ink); }
.matrix th.number { writing-mode: vertical-rl; transform: rotate(180deg); text-align: left;
  padding: 0.4rem 0 0 0; line-height: 1.2; }
.matrix td.number { min-width: 3.4rem; }
strong { font-weight: 700; }
.small table { font-size: 0.76rem; }
.small th, .small td { padding-top: 0.12rem; padding-bottom: 0.12rem; }
svg { display: block; width: 100%; height: auto; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 29rem), 1fr)); gap: 1.4rem 1.6rem; }
.plot { max-width: 38rem; }
.plot text, .bar text { font-size: 11.5px; fill: var(--ink); }
.plot .title { font-size: 13.5px; font-weight: 600; }
.plot .tick, .plot .label { fill: var(--soft); }
.plot .grid { stroke: var(--hair); }
.track { fill: var(--track); }
.plot .axis { fill: none; stroke: #8a949d; }
.plot .leader { stroke: #b5bdc4; stroke-width: 0.8; }
.plot .front { fill: none; stroke: #8a949d; stroke-width: 1.2; }
.case { break-inside: avoid; }
.pictures { display: grid; grid-template-columns: repeat(3, 1fr); gap: 0.9rem 1.2rem; align-items: start; }
.pictures div { font: 600 0.86rem/1.35 "Source Sans 3", "Source Sans Pro", "Helvetica Neue", "Segoe UI", Roboto,
  "Liberation Sans", Arial, sans-serif; }
.pictures div span { display: block; font-weight: 400; color: var(--soft); }
.pictures img { display: block; width: 100%; height: auto; margin-bottom: 0.3rem; }
.bar { max-width: 17rem; }
@media (max-width: 40rem) {
  body { font-size: 1rem; }
  main { padding: 1.5rem 1rem 3rem; }
  h1 { font-size: 1.9rem; }
  .facts { grid-template-columns: 1fr; gap: 0; }
  .facts dd { margin-bottom: 0.5rem; }
  .pictures { gap: 0.6rem; }
  .legend { grid-column: 1 / -1; display: flex; gap: 1rem; }
  .legend + div { grid-column: 2; }
  /* Words wrap anywhere, so that the first errors are seen without scrolling sideways. */
  table { font-size: 0.72rem; }
  td:not(.number), td:first-child { white-space: normal; overflow-wrap: anywhere; min-width: 3.2rem; padding-right: 0.3rem; }
  th.number, td.number { padding-left: 0.4rem; }
  .matrix td.number { min-width: 2.4rem; }
}
@media screen and (prefers-color-scheme: dark) {
  :root { --ink: #e4e8eb; --soft: #a9b4bd; --line: #3a434b; --paper: #15191d; --tint: #222930; --accent: #74bfe0;
    --hair: #2b333a; --warm: #2d2716; --track: #333c44; }
  /* What is drawn has the colours that it has on paper, on a card of that. */
  .plot, .bar, .pictures img { --ink: #1d2329; --soft: #56606a; --hair: #e3e7ea; background: #ffffff;
    border-radius: 6px; }
  .plot, .bar { padding: 0.4rem; }
}
@page { size: A4; margin: 16mm 14mm; }
@media print {
  html { font-size: 9pt; }
  body { font-size: 1rem; line-height: 1.4; }
  main { max-width: none; padding: 0; }
  h1 { font-size: 22pt; }
  h2 { font-size: 14pt; margin-top: 1.6rem; break-after: avoid; }
  h3 { font-size: 11pt; break-after: avoid; }
  a { color: inherit; text-decoration: none; }
  figure { break-inside: avoid; }
  figure.table { break-inside: auto; }
  .wide { overflow: visible; }
  table { font-size: 7.2pt; }
  .small table { font-size: 5.6pt; }
  .number { padding-left: 0.4rem; }
  th, td { padding-right: 0.4rem; }
  .matrix td.number { min-width: 0; }
  thead { display: table-header-group; }
  tr { break-inside: avoid; }
  .plots { grid-template-columns: 1fr 1fr; gap: 3mm 6mm; }
  .pictures { max-width: 150mm; gap: 2mm 4mm; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
)";

} // namespace livermark::report
