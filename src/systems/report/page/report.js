'use strict';
// Shows what data.js holds. Whatever comes from a run becomes text, never markup.

const data = rangegrasp.data;
const pageSize = 50;  // rows of the list that are added at a time
// A case's row in data.js.
const CASE = {run: 0, id: 1, title: 2, outcome: 3, stage: 4, detail: 5, seconds: 6, view: 7};
// At least 3:1 against white, distinguishable for people who see colours differently (after Okabe and Ito).
const colors = ['#0072b2', '#d55e00', '#007a5a', '#a8467f', '#7a5195', '#8a6d00', '#56606b', '#b3261e', '#2f6f9f', '#5a7d1a', '#444444'];

const $ = id => document.getElementById(id);

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

function button(text, action, className = '') {
  const made = element('button', {type: 'button', textContent: text, className});
  made.addEventListener('click', action);
  return made;
}

// A script of the report, once; a page from disk may load data no other way.
const loading = {};
function load(file) {
  loading[file] ??= new Promise((resolve, reject) => {
    const script = element('script', {src: file});
    script.onload = resolve;
    script.onerror = () => {
      delete loading[file];
      reject(new Error(`${file} is missing: was the report copied whole?`));
    };
    document.head.append(script);
  });
  return loading[file];
}
rangegrasp.load = load;
rangegrasp.element = element;

// ---- downloads ----

function download(url, title, ending) {
  const name = title.toLowerCase().replace(/[^a-z0-9]+/g, '-').replace(/^-|-$/g, '') || 'table';
  element('a', {href: url, download: `${name}.${ending}`}).click();
}

function downloadTable(title, rows) {
  const cell = value => /[",\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value;
  const text = rows.map(row => row.map(value => cell(String(value))).join(',') + '\n').join('');
  download(`data:text/csv;charset=utf-8,${encodeURIComponent(text)}`, title, 'csv');
}

// Twice the size on the screen, on white.
function downloadPicture(chart, title) {
  const ratio = chart.currentDevicePixelRatio;
  chart.options.devicePixelRatio = 2;
  chart.resize();
  const flat = element('canvas', {width: chart.canvas.width, height: chart.canvas.height});
  const context = flat.getContext('2d');
  context.fillStyle = '#fff';
  context.fillRect(0, 0, flat.width, flat.height);
  context.drawImage(chart.canvas, 0, 0);
  chart.options.devicePixelRatio = ratio;
  chart.resize();
  download(flat.toDataURL('image/png'), title, 'png');
}

// ---- tables and charts ----

// A cell is a text or an element.
function table(grid) {
  const align = i => grid.left[i] ? 'left' : '';
  const made = element('table');
  if (grid.title) made.append(element('caption', {textContent: grid.title}));
  made.append(element('thead', {}, element('tr', {}, ...grid.header.map(
      (cell, i) => element('th', {scope: 'col', className: align(i), textContent: cell})))));
  const body = element('tbody');
  grid.rows.forEach((row, r) => {
    const isTotal = grid.total && r === grid.rows.length - 1;
    body.append(element('tr', {className: isTotal ? 'total' : ''}, ...row.map((cell, i) => element('td', {className: align(i)}, cell))));
  });
  made.append(body);
  const name = grid.name || grid.title || 'Table';
  return element('div', {}, element('div', {className: 'scroll', tabIndex: 0, role: 'region', ariaLabel: name}, made),
      button('Download CSV', () => downloadTable(name, [...made.rows].map(one => [...one.cells].map(cell => cell.textContent))), 'small'));
}

const digits = value => Math.abs(value) >= 10 ? value.toFixed(1) : String(Number(value.toPrecision(3)));

function valueText(value, unit) {
  if (!value) return '-';
  const range = value.range ? ` (${digits(value.range[0])} to ${digits(value.range[1])})` : '';
  return `${digits(value.value)} ${unit}${range}${value.of ? `, ${value.of}` : ''}`;
}

const rangeSuffix = ' range';  // of the bar that shows a value's interval

function datasets(chart) {
  if (chart.stacked) {
    return chart.series.map((series, i) => ({
      type: 'bar', label: series.name, stack: 'all', maxBarThickness: 30, backgroundColor: colors[i % colors.length],
      data: series.values.map(v => v ? v.value : null)}));
  }
  return chart.series.flatMap((series, i) => {
    const color = colors[i % colors.length];
    const mark = {
      type: 'line', label: series.name, showLine: false, clip: false, pointRadius: 5, pointStyle: i === 0 ? 'circle' : 'rectRot',
      backgroundColor: color, borderColor: color, data: series.values.map(v => v ? v.value : null)};
    const range = {
      type: 'bar', label: series.name + rangeSuffix, isRange: true, grouped: false, barThickness: 4, backgroundColor: color + '88',
      data: series.values.map(v => v && v.range ? v.range : null)};
    return series.values.some(v => v && v.range) ? [mark, range] : [mark];
  });
}

function figure(chart) {
  const isLong = Math.max(...chart.labels.map(label => label.length)) > 8;
  const canvas = element('canvas', {role: 'img', ariaLabel: `${chart.title}; the numbers stand below it`});
  const holder = element('div', {className: 'canvas'}, canvas);
  holder.style.height = isLong ? `${90 + 26 * chart.labels.length}px` : '260px';
  const number = (series, i) => {
    const text = valueText(series.values[i], chart.unit);
    return series.values[i]?.cases ? button(text, () => listCases(chart, series, i), 'link') : text;
  };
  const numbers = {
    name: chart.title, title: '', left: [true, ...chart.series.map(() => true)], header: [chart.along, ...chart.series.map(s => s.name)], total: false,
    rows: chart.labels.map((label, i) => [label, ...chart.series.map(s => number(s, i))])};
  const made = element('figure', {}, element('figcaption', {textContent: chart.title}), holder);
  if (chart.note) made.append(element('p', {className: 'note', textContent: chart.note}));
  made.append(element('details', {}, element('summary', {textContent: 'Numbers'}), table(numbers)));
  const values = {beginAtZero: true, stacked: chart.stacked, title: {display: true, text: chart.unit}};
  if (chart.unit === '%') values.max = 100;
  if (chart.stacked) values.ticks = {precision: 0};
  const labels = {stacked: chart.stacked, title: {display: true, text: chart.along}, ticks: {autoSkip: false}};
  const seriesOf = dataset => chart.series.find(s => s.name === dataset.label.replace(rangeSuffix, ''));
  const drawn = new Chart(canvas, {
    data: {labels: chart.labels, datasets: datasets(chart)},
    options: {
      indexAxis: isLong ? 'y' : 'x', animation: false, maintainAspectRatio: false,
      scales: isLong ? {x: values, y: labels} : {x: labels, y: values},
      onClick: (event, items) => {
        if (items.length === 0) return;
        const {datasetIndex, index} = items[0];
        listCases(chart, seriesOf(drawn.data.datasets[datasetIndex]), index);
      },
      plugins: {
        legend: {display: chart.stacked || chart.series.length > 1, labels: {usePointStyle: !chart.stacked, boxHeight: 6, filter: (item, all) => !all.datasets[item.datasetIndex].isRange}},
        tooltip: {
          filter: item => !item.dataset.isRange,
          callbacks: {
            label: item => {
              const series = seriesOf(item.dataset);
              return `${series.name}: ${valueText(series.values[item.dataIndex], chart.unit)}`;
            }}}}}});
  made.append(button('Download PNG', () => downloadPicture(drawn, chart.title), 'small'));
  return made;
}

function showRun(run, number) {
  const section = element('section', {id: `run-${number}`}, element('h2', {textContent: run.name}));
  section.append(...run.tables.map(table));
  section.append(...run.notes.map(note => element('p', {className: 'note', textContent: note})));
  const charts = element('div', {className: 'charts'});
  section.append(charts);
  $('runs').append(section);
  charts.append(...run.charts.map(figure));
  const stamp = {title: run.name, header: ['', ''], left: [true, true], total: false, rows: run.stamp};
  $('stamps').append(table(stamp), element('details', {}, element('summary', {textContent: 'Experiment file'}),
      element('pre', {textContent: run.experiment})));
}

function showComparison(pair) {
  $('comparisons').hidden = false;
  const both = [pair.first, pair.second];
  const cases = element('table', {}, element('caption', {textContent: `Cases that are ${pair.success} in one run only`}),
      element('thead', {}, element('tr', {}, ...both.map(name => element('th', {scope: 'col', className: 'left', textContent: name})))),
      element('tbody', {}, ...pair.differing.map(numbers => element('tr', {}, ...numbers.map(
          n => element('td', {className: 'left'}, caseButton(n), ` ${data.cases[n][CASE.outcome]}`))))));
  $('comparisons').append(element('h3', {textContent: `${pair.first} and ${pair.second}`}));
  if (pair.table.rows.length === 0) {
    $('comparisons').append(element('p', {textContent: 'The two runs have no case with the same id and seed.'}));
    return;
  }
  $('comparisons').append(table(pair.table));
  if (pair.differing.length > 0) $('comparisons').append(element('details', {open: true}, element('summary', {textContent: 'Cases that differ'}), cases));
}

// ---- the list of cases ----

const filters = {};
let ofChart = null;  // {text, cases}: the cases that a chart's value counts, if one was selected
let order = {column: null, sign: 1};
let shown = [];  // numbers of the cases that pass the filters, in the order of the list

// A case's address after '#': its id, and which of the cases with this id it is if it is not the first.
const addresses = [];
const numberOf = new Map();

function setUpAddresses() {
  const counts = new Map();
  data.cases.forEach((one, number) => {
    const count = (counts.get(one[CASE.id]) ?? 0) + 1;
    counts.set(one[CASE.id], count);
    addresses.push(encodeURI(count === 1 ? one[CASE.id] : `${one[CASE.id]}@${count}`));
    numberOf.set(addresses[number], number);
  });
}

function caseButton(number) {
  const made = button(data.cases[number][CASE.id], () => openCase(number));
  made.dataset.number = number;
  return made;
}

// The list's columns after the picture: title, text of a case, what it is sorted by.
const columns = [
  {title: 'case', of: one => one[CASE.id]}, {title: 'group', of: one => one[CASE.title]}, {title: 'outcome', of: one => one[CASE.outcome]},
  {title: 'stage', of: one => one[CASE.stage]}, {title: 'seconds', of: one => one[CASE.seconds], text: one => one[CASE.seconds].toFixed(2)},
  {title: 'detail', of: one => one[CASE.detail], className: 'detail'}];
if (data.runs.length > 1) columns.push({title: 'run', of: one => data.runs[one[CASE.run]].name});
const textIn = (column, one) => (column.text ?? column.of)(one);

function row(number) {
  const one = data.cases[number];
  const picture = element('td');
  if (one[CASE.view]) {
    picture.append(element('img', {src: `views/${number}.png`, loading: 'lazy', alt: '', width: 96, height: 72}));
  }
  return element('tr', {}, picture, element('td', {}, caseButton(number)), ...columns.slice(1).map(
      column => element('td', {className: column.className ?? '', textContent: textIn(column, one)})));
}

function showMore() {
  const body = $('list').tBodies[0];
  const begin = body.rows.length;
  body.append(...shown.slice(begin, begin + pageSize).map(row));
  $('more').hidden = body.rows.length >= shown.length;
}

function compare(a, b) {
  return typeof a === 'number' ? a - b : a.localeCompare(b, 'en', {numeric: true});
}

function filterCases() {
  const wanted = $('search').value.trim().toLowerCase();
  const passes = (one, number) => (ofChart === null || ofChart.cases.has(number)) && one[CASE.id].toLowerCase().includes(wanted) &&
      Object.entries(filters).every(([key, select]) => select.value === '' || String(one[CASE[key]]) === select.value);
  shown = [...data.cases.keys()].filter(number => passes(data.cases[number], number));
  if (order.column) shown.sort((a, b) => order.sign * compare(order.column.of(data.cases[a]), order.column.of(data.cases[b])) || a - b);
  $('count').textContent = `${shown.length} of ${data.cases.length} cases`;
  $('of-chart').hidden = ofChart === null;
  $('of-chart-text').textContent = ofChart?.text ?? '';
  $('list').tBodies[0].replaceChildren();
  showMore();
}

// Shows the cases that a value of a chart counts, and no others.
function listCases(chart, series, i) {
  const {cases} = series.values[i] ?? {};
  if (!cases) return;
  ofChart = {text: `${chart.title}: ${chart.labels[i]}, ${series.name}`, cases: new Set(cases)};
  for (const select of Object.values(filters)) select.value = '';
  $('search').value = '';
  filterCases();
  $('trials').scrollIntoView();
  $('all-cases').focus();
}

// Up, down, then as in the run.
function sortBy(column, head) {
  if (order.column !== column) order = {column, sign: 1};
  else if (order.sign === 1) order.sign = -1;
  else order = {column: null, sign: 1};
  for (const one of head.parentNode.cells) one.removeAttribute('aria-sort');
  if (order.column) head.setAttribute('aria-sort', order.sign === 1 ? 'ascending' : 'descending');
  filterCases();
}

function addFilter(key, name, textOf = String) {
  const values = [...new Set(data.cases.map(one => one[CASE[key]]))];
  const select = element('select', {name: key}, new Option('all', ''), ...values.map(value => new Option(textOf(value), value)));
  select.addEventListener('change', filterCases);
  filters[key] = select;
  $('filters').append(element('label', {}, name, select));
}

function setUpList() {
  if (data.runs.length > 1) addFilter('run', 'Run', value => data.runs[value].name);
  $('view-note').textContent = data.viewNote;
  addFilter('title', 'Group');
  addFilter('outcome', 'Outcome');
  addFilter('stage', 'Last stage');
  addFilter('view', 'View', value => value ? 'with 3-D view' : 'without');
  const heads = columns.map(column => {
    const head = element('th', {scope: 'col'});
    head.append(button(column.title, () => sortBy(column, head), 'sort'));
    return head;
  });
  $('list').tHead.rows[0].append(element('td'), ...heads);
  $('filters').addEventListener('submit', event => event.preventDefault());
  $('search').addEventListener('input', filterCases);
  $('all-cases').addEventListener('click', () => {
    ofChart = null;
    filterCases();
  });
  $('download-list').addEventListener('click', () => downloadTable('cases', [
    columns.map(column => column.title), ...shown.map(number => columns.map(column => textIn(column, data.cases[number])))]));
  $('more').addEventListener('click', showMore);
  filterCases();
}

// ---- one case ----

let opened = -1;

function flat(value, name, into) {
  if (value !== null && typeof value === 'object' && !Array.isArray(value)) {
    for (const [key, inner] of Object.entries(value)) flat(inner, name ? `${name}.${key}` : key, into);
  } else {
    into.push([name, Array.isArray(value) ? JSON.stringify(value) : String(value ?? '')]);
  }
  return into;
}

function showRecord(record) {
  const list = element('dl');
  for (const [name, text] of flat(record, '', [])) {
    list.append(element('div', {}, element('dt', {textContent: name}), element('dd', {textContent: text})));
  }
  $('record').replaceChildren(list);
}

function hideViews() {
  rangegrasp.hideView?.();
  rangegrasp.hidePlots?.();
  $('view').replaceChildren();
}

async function showView(number) {
  if (!data.cases[number][CASE.view]) {
    $('view').textContent = 'This case has no 3-D view; `rangegrasp report --views all` makes one for each case.';
    return;
  }
  $('view').textContent = 'Loading';
  await load(`views/${number}.js`);
  const view = rangegrasp.views[number];
  const meshes = new Set([...view.bodies, ...view.painted].map(one => one.mesh));
  const isSolid = meshes.size + view.points.length + view.surfaces.length > 0;
  const isPlot = view.panels.length + view.pages.length > 0;
  await Promise.all([
    ...(isSolid ? [load('lib/three.min.js').then(() => load('lib/OrbitControls.js')), load('view.js')] : []),
    ...(isPlot ? [load('plots.js')] : []), ...[...meshes].map(mesh => load(`meshes/${mesh}.js`))]);
  if (opened !== number) return;
  hideViews();
  if (isSolid) rangegrasp.showView($('view'), view);
  if (isPlot) rangegrasp.showPlots($('view'), view);
}

function stepTo(button, number) {
  button.disabled = number === undefined;
  button.onclick = () => openCase(number);
}

async function openCase(number) {
  const one = data.cases[number];
  opened = number;
  $('case-title').textContent = one[CASE.id];
  $('case-text').textContent = `${one[CASE.title]}: ${one[CASE.outcome]}, ended in ${one[CASE.stage]}. ${one[CASE.detail]}`;
  const place = shown.indexOf(number);
  stepTo($('previous'), place > 0 ? shown[place - 1] : undefined);
  stepTo($('next'), place >= 0 ? shown[place + 1] : undefined);
  $('record').textContent = '';
  $('replay').textContent = replayOf(number);
  $('copied').textContent = '';
  history.replaceState(null, '', `#${addresses[number]}`);
  if (!$('case').open) $('case').showModal();
  const block = Math.floor(number / data.block);
  try {
    await Promise.all([
      showView(number), load(`records/${block}.js`).then(() => {
        if (opened === number) showRecord(rangegrasp.records[block][number - block * data.block]);
      })]);
  } catch (error) {
    if (opened === number) $('view').textContent = error.message;
  }
}

// The command that runs a case again.
function replayOf(number) {
  const one = data.cases[number];
  const word = text => /^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;
  const [, folder] = data.runs[one[CASE.run]].stores.findLast(([first]) => first <= number);
  return `rangegrasp trial ${word(folder)} ${word(one[CASE.id])}`;
}

// A page from disk may be refused the clipboard: then the command is selected.
async function copyReplay() {
  try {
    await navigator.clipboard.writeText($('replay').textContent);
    $('copied').textContent = 'Copied';
  } catch {
    getSelection().selectAllChildren($('replay'));
    $('copied').textContent = 'Selected: press Ctrl+C';
  }
}

// Opens the case that the page's address names.
function openNamed() {
  const number = numberOf.get(location.hash.slice(1));
  if (number !== undefined && number !== opened) openCase(number);
}

function setUpCase() {
  $('close').addEventListener('click', () => $('case').close());
  $('copy').addEventListener('click', copyReplay);
  $('case').addEventListener('close', () => {
    opened = -1;
    history.replaceState(null, '', location.pathname);
    hideViews();
  });
  window.addEventListener('hashchange', openNamed);
  openNamed();
}

// ---- the whole page ----

Chart.defaults.color = '#333';
document.title = `${data.runs.map(run => run.name).join(', ')} - rangegrasp report`;
$('title').textContent = data.runs.map(run => run.name).join(' and ');
data.runs.forEach(showRun);
data.comparisons.forEach(showComparison);
setUpAddresses();
setUpList();
for (const section of document.querySelectorAll('section:not([hidden])')) {
  document.querySelector('nav').append(element('a', {href: `#${section.id}`, textContent: section.querySelector('h2').textContent}));
}
window.addEventListener('beforeprint', () => Object.values(Chart.instances).forEach(chart => chart.resize()));
setUpCase();
