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

// ---- tables and charts ----

function table(grid) {
  const align = i => grid.left[i] ? 'left' : '';
  const made = element('table');
  if (grid.title) made.append(element('caption', {textContent: grid.title}));
  made.append(element('thead', {}, element('tr', {}, ...grid.header.map(
      (cell, i) => element('th', {scope: 'col', className: align(i), textContent: cell})))));
  const body = element('tbody');
  grid.rows.forEach((row, r) => {
    const isTotal = grid.total && r === grid.rows.length - 1;
    body.append(element('tr', {className: isTotal ? 'total' : ''}, ...row.map(
        (cell, i) => element('td', {className: align(i), textContent: cell}))));
  });
  made.append(body);
  return element('div', {className: 'scroll', tabIndex: 0, role: 'region', ariaLabel: grid.title || 'Table'}, made);
}

const digits = value => Math.abs(value) >= 10 ? value.toFixed(1) : String(Number(value.toPrecision(3)));

function valueText(value, unit) {
  if (!value) return '-';
  const range = value.range ? ` (${digits(value.range[0])} to ${digits(value.range[1])})` : '';
  return `${digits(value.value)} ${unit}${range}${value.of ? `, ${value.of}` : ''}`;
}

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
      type: 'bar', label: series.name + ' range', isRange: true, grouped: false, barThickness: 4, backgroundColor: color + '88',
      data: series.values.map(v => v && v.range ? v.range : null)};
    return series.values.some(v => v && v.range) ? [mark, range] : [mark];
  });
}

function figure(chart) {
  const isLong = Math.max(...chart.labels.map(label => label.length)) > 8;
  const canvas = element('canvas', {role: 'img', ariaLabel: `${chart.title}; the numbers stand below it`});
  const holder = element('div', {className: 'canvas'}, canvas);
  holder.style.height = isLong ? `${90 + 26 * chart.labels.length}px` : '260px';
  const numbers = {
    title: '', left: [true, ...chart.series.map(() => true)], header: [chart.along, ...chart.series.map(s => s.name)], total: false,
    rows: chart.labels.map((label, i) => [label, ...chart.series.map(s => valueText(s.values[i], chart.unit))])};
  const made = element('figure', {}, element('figcaption', {textContent: chart.title}), holder);
  if (chart.note) made.append(element('p', {className: 'note', textContent: chart.note}));
  made.append(element('details', {}, element('summary', {textContent: 'Numbers'}), table(numbers)));
  const values = {beginAtZero: true, stacked: chart.stacked, title: {display: true, text: chart.unit}};
  if (chart.unit === '%') values.max = 100;
  if (chart.stacked) values.ticks = {precision: 0};
  const labels = {stacked: chart.stacked, title: {display: true, text: chart.along}, ticks: {autoSkip: false}};
  new Chart(canvas, {
    data: {labels: chart.labels, datasets: datasets(chart)},
    options: {
      indexAxis: isLong ? 'y' : 'x', animation: false, maintainAspectRatio: false,
      scales: isLong ? {x: values, y: labels} : {x: labels, y: values},
      plugins: {
        legend: {display: chart.stacked || chart.series.length > 1, labels: {usePointStyle: !chart.stacked, boxHeight: 6, filter: (item, all) => !all.datasets[item.datasetIndex].isRange}},
        tooltip: {
          filter: item => !item.dataset.isRange,
          callbacks: {
            label: item => {
              const series = chart.series.find(s => s.name === item.dataset.label);
              return `${series.name}: ${valueText(series.values[item.dataIndex], chart.unit)}`;
            }}}}}});
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
let shown = [];  // numbers of the cases that pass the filters

function caseButton(number) {
  const button = element('button', {type: 'button', textContent: data.cases[number][CASE.id]});
  button.dataset.number = number;
  button.addEventListener('click', () => openCase(number));
  return button;
}

function row(number) {
  const one = data.cases[number];
  const picture = element('td');
  if (one[CASE.view]) {
    picture.append(element('img', {src: `views/${number}.png`, loading: 'lazy', alt: '', width: 96, height: 72}));
  }
  const cells = ['title', 'outcome', 'stage'].map(key => element('td', {textContent: one[CASE[key]]}));
  const made = element('tr', {}, picture, element('td', {}, caseButton(number)), ...cells,
      element('td', {textContent: one[CASE.seconds].toFixed(2)}), element('td', {className: 'detail', textContent: one[CASE.detail]}));
  if (data.runs.length > 1) made.append(element('td', {textContent: data.runs[one[CASE.run]].name}));
  return made;
}

function showMore() {
  const body = $('list').tBodies[0];
  const begin = body.rows.length;
  body.append(...shown.slice(begin, begin + pageSize).map(row));
  $('more').hidden = body.rows.length >= shown.length;
}

function filterCases() {
  shown = [];
  data.cases.forEach((one, number) => {
    if (Object.entries(filters).every(([key, select]) => select.value === '' || String(one[CASE[key]]) === select.value)) shown.push(number);
  });
  $('count').textContent = `${shown.length} of ${data.cases.length} cases`;
  $('list').tBodies[0].replaceChildren();
  showMore();
}

function addFilter(key, name, textOf = String) {
  const values = [...new Set(data.cases.map(one => one[CASE[key]]))];
  const select = element('select', {name: key}, new Option('all', ''), ...values.map(value => new Option(textOf(value), value)));
  select.addEventListener('change', filterCases);
  filters[key] = select;
  $('filters').append(element('label', {}, name, select));
}

function setUpList() {
  const names = ['', 'case', 'group', 'outcome', 'stage', 'seconds', 'detail'];
  if (data.runs.length > 1) {
    names.push('run');
    addFilter('run', 'Run', value => data.runs[value].name);
  }
  $('view-note').textContent = data.viewNote;
  addFilter('title', 'Group');
  addFilter('outcome', 'Outcome');
  addFilter('stage', 'Last stage');
  addFilter('view', 'View', value => value ? 'with 3-D view' : 'without');
  $('list').tHead.rows[0].append(...names.map(name => element('th', {scope: 'col', textContent: name})));
  $('filters').addEventListener('submit', event => event.preventDefault());
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

function setUpCase() {
  $('close').addEventListener('click', () => $('case').close());
  $('case').addEventListener('close', () => {
    opened = -1;
    hideViews();
  });
}

// ---- the whole page ----

Chart.defaults.color = '#333';
document.title = `${data.runs.map(run => run.name).join(', ')} - rangegrasp report`;
$('title').textContent = data.runs.map(run => run.name).join(' and ');
data.runs.forEach(showRun);
data.comparisons.forEach(showComparison);
setUpList();
setUpCase();
for (const section of document.querySelectorAll('section:not([hidden])')) {
  document.querySelector('nav').append(element('a', {href: `#${section.id}`, textContent: section.querySelector('h2').textContent}));
}
window.addEventListener('beforeprint', () => Object.values(Chart.instances).forEach(chart => chart.resize()));
