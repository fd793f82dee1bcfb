'use strict';
// Draws one case's diagrams: those that are always shown, and pages of them that a slider leafs through.
(() => {
  const element = rangegrasp.element;
  const height_px = 260;
  let charts = [];

  function numbers(packed) {
    const raw = atob(packed.data);
    return Float64Array.from({length: raw.length / 2}, (_, i) => {
      const steps = raw.charCodeAt(2 * i) + 256 * raw.charCodeAt(2 * i + 1);
      return steps === 65535 ? NaN : packed.low + packed.step * steps;
    });
  }

  // Lowest and highest finite value.
  function range(all) {
    let low = Infinity, high = -Infinity;
    for (const one of all) {
      for (const value of one) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    return low <= high ? [low, high] : [0, 1];
  }

  function curve(series) {
    const y = numbers(series.y), x = series.x ? numbers(series.x) : y.map((_, i) => i);
    return {
      label: series.name, data: Array.from(x, (value, i) => ({x: value, y: y[i]})), borderColor: series.color, backgroundColor: series.color,
      showLine: !series.dots, borderWidth: 1.5, pointRadius: series.dots ? 2 : 0, pointHitRadius: 4};
  }

  function mark(marker, heights) {
    return {
      label: marker.name, data: heights.map(y => ({x: marker.x, y})), borderColor: marker.color, backgroundColor: marker.color,
      showLine: true, borderWidth: 2, borderDash: [6, 3], pointRadius: 0};
  }

  function axis(name, limits) {
    return {type: 'linear', title: {display: name !== '', text: name}, ...(limits ? {min: limits[0], max: limits[1]} : {})};
  }

  function show(panel, holder) {
    const canvas = element('canvas', {role: 'img'});
    const names = [...panel.series, ...panel.markers].map(one => one.name).filter(name => name !== '');
    canvas.setAttribute('aria-label', names.length > 0 ? `${panel.title}: ${names.join(', ')}` : panel.title);
    const box = element('div', {className: 'canvas'}, canvas);
    box.style.height = `${height_px}px`;
    holder.append(element('figure', {}, element('figcaption', {textContent: panel.title}), box));
    const curves = panel.series.map(curve);
    const across = range(curves.map(one => one.data.map(p => p.x))), up = range(curves.map(one => one.data.map(p => p.y)));
    // One unit as long on both axes: within what labels of about 80 pixels leave.
    const half = 0.5 * (across[1] - across[0]) * (height_px - 80) / Math.max(100, box.clientWidth - 80), middle = 0.5 * (up[0] + up[1]);
    const limits = panel.equal && half > 0.5 * (up[1] - up[0]) ? [middle - half, middle + half] : undefined;
    charts.push(new Chart(canvas, {
      type: 'scatter', data: {datasets: [...curves, ...panel.markers.map(one => mark(one, up))]},
      options: {
        animation: false, maintainAspectRatio: false, scales: {x: axis(panel.x, across), y: axis(panel.y, limits)},
        plugins: {legend: {display: names.length > 0, labels: {boxHeight: 1, boxWidth: 20, filter: item => item.text !== ''}}}}}));
  }

  function free(some) {
    for (const chart of some) chart.destroy();
    charts = charts.filter(chart => !some.includes(chart));
  }

  function leaf(pages) {
    const slider = element('input', {type: 'range', min: 0, max: pages.length - 1, value: 0, ariaLabel: 'Page'});
    const name = element('output');
    const holder = element('div');
    let shown = [];
    const turn = () => {
      free(shown);
      holder.replaceChildren();
      const page = pages[Number(slider.value)];
      name.textContent = page.name;
      slider.setAttribute('aria-valuetext', page.name);
      const before = charts.length;
      for (const panel of page.panels) show(panel, holder);
      shown = charts.slice(before);
    };
    slider.addEventListener('input', turn);
    return {bar: element('div', {className: 'player'}, slider, name), holder, turn};
  }

  rangegrasp.showPlots = (into, view) => {
    const holder = element('div');
    into.append(holder);
    for (const panel of view.panels) show(panel, holder);
    if (view.pages.length === 0) return;
    const pages = leaf(view.pages);
    holder.append(pages.bar, pages.holder);
    pages.turn();
  };
  rangegrasp.hidePlots = () => free([...charts]);
})();
