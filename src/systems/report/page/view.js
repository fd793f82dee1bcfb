'use strict';
// Draws one case in 3-D: what was perceived, what happened, in time, and what is painted, side by side. One renderer serves all cases; it
// draws when something changes.
(() => {
  const element = rangegrasp.element;
  const forceLength_m = 0.001;  // of an arrow, for each newton
  const arrowColor = 0xc2185b;
  const pointSize_px = 2;
  const replayEye = [0.95, -1.05, 0.75];  // from what is looked at, where the arm shows as well
  const width = 860, height = 560;
  const halfField = Math.tan(35 / 2 * Math.PI / 180);  // of what is seen, up and down

  let renderer, camera, controls, scene, present, playing;

  // ---- numbers ----

  function bytes(text) {
    const raw = atob(text);
    const all = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; ++i) all[i] = raw.charCodeAt(i);
    return all.buffer;
  }
  function points(packed) {
    return Float32Array.from(new Uint16Array(bytes(packed.data)), (steps, i) => packed.low[i % 3] + packed.step * steps);
  }
  function geometry(mesh) {
    const made = new THREE.BufferGeometry();
    made.setAttribute('position', new THREE.BufferAttribute(points(mesh.vertices), 3));
    const corners = bytes(mesh.triangles);
    made.setIndex(new THREE.BufferAttribute(mesh.wide ? new Uint32Array(corners) : new Uint16Array(corners), 1));
    return made;
  }
  function material(color) {
    const clear = color[3] < 1;
    return new THREE.MeshPhongMaterial({
      color: new THREE.Color(color[0], color[1], color[2]), opacity: color[3], transparent: clear, depthWrite: !clear, flatShading: true,
      shininess: 15, side: THREE.DoubleSide});
  }

  // ---- what is in the scene ----

  function setUp() {
    renderer = new THREE.WebGLRenderer({antialias: true});
    renderer.setClearColor(0xffffff);
    renderer.setSize(width, height, false);
    camera = new THREE.PerspectiveCamera(35, width / height, 0.01, 30);
    camera.up.set(0, 0, 1);
    const canvas = renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute('aria-label', '3-D view: drag or use the arrow keys to rotate, scroll or use + and - to zoom');
    controls = new THREE.OrbitControls(camera, canvas);
    controls.enableKeys = false;  // they would act on the whole page
    controls.addEventListener('change', draw);
    canvas.addEventListener('keydown', turn);
  }

  function lights() {
    const sun = new THREE.DirectionalLight(0xffffff, 0.75);
    sun.position.set(1, -2, 3);
    const back = new THREE.DirectionalLight(0xffffff, 0.35);
    back.position.set(-2, 1, 1);
    scene.add(new THREE.AmbientLight(0xffffff, 0.45), sun, back);
  }

  function layer(name, color) {
    if (!present.layers[name]) {
      const group = new THREE.Group();
      scene.add(group);
      present.layers[name] = {group, color};
    }
    return present.layers[name].group;
  }

  function addBody(body) {
    const mesh = new THREE.Mesh(geometry(rangegrasp.meshes[body.mesh]), material(body.color));
    mesh.matrixAutoUpdate = false;
    mesh.name = body.name;
    layer(body.layer, body.color).add(mesh);
    present.bodies.push({mesh, places: points(body.poses.places), turns: new Int16Array(bytes(body.poses.turns))});
  }

  function addPerceived(view) {
    for (const one of view.points) {
      const made = new THREE.BufferGeometry();
      made.setAttribute('position', new THREE.BufferAttribute(points(one.points), 3));
      layer(one.layer, one.color).add(new THREE.Points(made, new THREE.PointsMaterial({
        color: new THREE.Color(...one.color.slice(0, 3)), size: pointSize_px, sizeAttenuation: false})));
    }
    for (const one of view.surfaces) layer(one.layer, one.color).add(new THREE.Mesh(geometry(one.mesh), material(one.color)));
    for (const one of view.lines) {
      const made = new THREE.BufferGeometry();
      made.setAttribute('position', new THREE.BufferAttribute(points(one.points), 3));
      layer(one.layer, one.color).add(new THREE.Line(made, new THREE.LineBasicMaterial({color: new THREE.Color(...one.color.slice(0, 3))})));
    }
  }

  // Triangles with colours of their own share no corners.
  function addPainted(one) {
    const shared = geometry(rangegrasp.meshes[one.mesh]);
    const made = shared.toNonIndexed();
    shared.dispose();
    const paint = new Uint8Array(bytes(one.paint));
    const shades = new Float32Array(9 * paint.length);
    paint.forEach((color, i) => {
      for (let k = 0; k < 9; ++k) shades[9 * i + k] = one.colors[color][k % 3];
    });
    made.setAttribute('color', new THREE.BufferAttribute(shades, 3));
    const mesh = new THREE.Mesh(made, new THREE.MeshPhongMaterial({
      vertexColors: THREE.VertexColors, flatShading: true, shininess: 15, side: THREE.DoubleSide}));
    layer(one.layer).add(mesh);
    const name = element('span', {textContent: one.layer});
    present.cells.push({layer: present.layers[one.layer], name});
  }

  function freeAll() {
    if (!scene) return;
    scene.traverse(one => {
      one.geometry?.dispose();
      one.material?.dispose();
    });
  }

  // ---- time ----

  function pose(body, frame) {
    const at = body.turns.length > 4 ? frame : 0;
    const turn = new THREE.Quaternion(...body.turns.subarray(4 * at, 4 * at + 4)).normalize();
    body.mesh.matrix.compose(new THREE.Vector3(...body.places.subarray(3 * at, 3 * at + 3)), turn, new THREE.Vector3(1, 1, 1));
  }

  function showForces(forces) {
    const group = layer('contact forces', [0.76, 0.09, 0.36, 1]);
    for (const arrow of [...group.children]) {
      arrow.line.geometry.dispose();
      arrow.line.material.dispose();
      arrow.cone.material.dispose();
      group.remove(arrow);
    }
    for (let i = 0; i < forces.length; i += 6) {
      const force = new THREE.Vector3(...forces.slice(i + 3, i + 6));
      const length = Math.max(0.008, forceLength_m * force.length());
      const arrow = new THREE.ArrowHelper(force.normalize(), new THREE.Vector3(...forces.slice(i, i + 3)), length, arrowColor, 0.008, 0.005);
      for (const part of [arrow.line, arrow.cone]) part.material.depthTest = false;
      arrow.renderOrder = 1;
      group.add(arrow);
    }
  }

  function showFrame(frame) {
    const {view, slider, clock} = present;
    const {time, forces} = view.frames[frame];
    present.frame = frame;
    slider.value = frame;
    present.bodies.forEach(body => pose(body, frame));
    showForces(forces);
    const named = view.frames.slice(0, frame + 1).reverse().find(one => one.moment !== '');
    let sum = 0;
    for (let i = 0; i < forces.length; i += 6) sum += Math.hypot(...forces.slice(i + 3, i + 6));
    const forceText = sum > 0 ? `, contact forces of the hand ${sum.toFixed(1)} N in total` : '';
    clock.textContent = `${(time - view.frames[0].time).toFixed(1)} s${named ? `, after ${named.moment}` : ''}${forceText}`;
    slider.setAttribute('aria-valuetext', clock.textContent);
    draw();
  }

  function play() {
    if (playing) return stop();
    const {frames} = present.view;
    if (present.frame >= frames.length - 1) showFrame(0);
    showHappened();
    const began = performance.now() / 1000 - frames[present.frame].time;
    const shownCase = present;
    present.button.textContent = 'Pause';
    const step = () => {
      if (present !== shownCase) return stop();
      const time = performance.now() / 1000 - began;
      let frame = present.frame;
      while (frame < frames.length - 1 && frames[frame + 1].time <= time) ++frame;
      if (frame !== present.frame) showFrame(frame);
      playing = frame < frames.length - 1 ? requestAnimationFrame(step) : stop();
    };
    playing = requestAnimationFrame(step);
  }

  function stop() {
    if (playing) cancelAnimationFrame(playing);
    playing = undefined;
    if (present) present.button.textContent = 'Play';
  }

  // ---- looking ----

  function seeThrough(aspect) {
    camera.aspect = aspect;
    camera.fov = 360 / Math.PI * Math.atan(halfField / Math.min(1, aspect));
    camera.updateProjectionMatrix();
  }

  // As many columns as make the pictures largest.
  function columnsFor(count) {
    const size = columns => Math.min(width / columns, height / Math.ceil(count / columns));
    return Array.from({length: count}, (_, i) => i + 1).reduce((best, one) => size(one) > size(best) ? one : best, 1);
  }

  // Each in a picture of its own, all from the same side.
  function drawCells(cells) {
    const columns = columnsFor(cells.length), rows = Math.ceil(cells.length / columns);
    const wide = Math.floor(width / columns), high = Math.floor(height / rows);
    renderer.clear();
    renderer.setScissorTest(true);
    seeThrough(wide / high);
    cells.forEach(({layer, name}, i) => {
      const left = i % columns, top = Math.floor(i / columns);
      for (const other of cells) other.layer.group.visible = other.layer === layer;
      const box = [left * wide, height - (top + 1) * high, wide, high];
      renderer.setViewport(...box);
      renderer.setScissor(...box);
      renderer.render(scene, camera);
      name.style.left = `${100 * left * wide / width}%`;
      name.style.top = `${100 * top * high / height}%`;
    });
    for (const {layer} of cells) layer.group.visible = true;
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, width, height);
  }

  function draw() {
    if (!scene) return;
    for (const {layer, name} of present.cells) name.hidden = !layer.group.visible;
    const cells = present.cells.filter(cell => cell.layer.group.visible);
    if (cells.length > 0) return drawCells(cells);
    seeThrough(width / height);
    renderer.render(scene, camera);
  }

  function lookFrom(eye, target) {
    controls.target.set(...target);
    camera.position.set(...eye);
    controls.update();
    draw();
  }

  function turn(event) {
    const offset = new THREE.Spherical().setFromVector3(camera.position.clone().sub(controls.target).applyAxisAngle(new THREE.Vector3(1, 0, 0), -Math.PI / 2));
    const step = 0.12;
    switch (event.key) {
      case 'ArrowLeft': offset.theta -= step; break;
      case 'ArrowRight': offset.theta += step; break;
      case 'ArrowUp': offset.phi -= step; break;
      case 'ArrowDown': offset.phi += step; break;
      case '+': offset.radius /= 1.1; break;
      case '-': offset.radius *= 1.1; break;
      default: return;
    }
    event.preventDefault();
    offset.makeSafe();
    camera.position.setFromSpherical(offset).applyAxisAngle(new THREE.Vector3(1, 0, 0), Math.PI / 2).add(controls.target);
    controls.update();
    draw();
  }

  function setShown(name, isShown) {
    const one = present.layers[name];
    one.group.visible = isShown;
    one.box.checked = isShown;
  }

  function showOnly(isShown, button) {
    for (const name of Object.keys(present.layers)) setShown(name, isShown(name));
    for (const one of present.modes) one.setAttribute('aria-pressed', String(one === button));
  }

  function showPerceived() {
    showOnly(name => !present.moving.has(name) && name !== 'colliding grasps', present.modes[0]);
    lookFrom(present.view.eye, present.view.target);
  }

  function showHappened() {
    if (present.modes[1].getAttribute('aria-pressed') === 'true') return;
    showOnly(name => present.moving.has(name), present.modes[1]);
    lookFrom(replayEye.map((x, i) => x + present.view.target[i]), present.view.target);
  }

  // ---- the page's part ----

  function layerBoxes() {
    const boxes = element('fieldset', {}, element('legend', {textContent: 'Shown'}));
    for (const [name, one] of Object.entries(present.layers)) {
      one.box = element('input', {type: 'checkbox', checked: true});
      one.box.addEventListener('change', () => {
        one.group.visible = one.box.checked;
        draw();
      });
      const swatch = element('span', {className: 'swatch'});
      if (one.color) swatch.style.background = `rgb(${one.color.slice(0, 3).map(c => Math.round(255 * c)).join()})`;
      boxes.append(element('label', {}, one.box, ...(one.color ? [swatch] : []), name));
    }
    return boxes;
  }

  function player(view) {
    present.slider = element('input', {type: 'range', min: 0, max: Math.max(0, view.frames.length - 1), value: 0, ariaLabel: 'Time'});
    present.slider.addEventListener('input', () => {
      stop();
      showHappened();
      showFrame(Number(present.slider.value));
    });
    present.button = element('button', {type: 'button', textContent: 'Play'});
    present.button.addEventListener('click', play);
    present.clock = element('output');
    const bar = element('div', {className: 'player'}, present.button, present.slider, present.clock);
    bar.hidden = view.frames.length < 2;
    return bar;
  }

  function modeButton(name, show) {
    const button = element('button', {type: 'button', textContent: name});
    button.addEventListener('click', show);
    return button;
  }

  rangegrasp.showView = (holder, view) => {
    try {
      if (!renderer) setUp();
    } catch (error) {
      holder.textContent = 'This browser cannot show 3-D views: WebGL is off.';
      return;
    }
    scene = new THREE.Scene();
    lights();
    present = {view, layers: {}, bodies: [], cells: [], frame: 0, moving: new Set([...view.bodies.map(body => body.layer), 'contact forces'])};
    addPerceived(view);
    view.painted.forEach(addPainted);
    view.bodies.forEach(addBody);
    const moves = view.frames.length > 0;
    if (moves) layer('contact forces', [0.76, 0.09, 0.36, 1]);
    present.modes = [modeButton('Perception', showPerceived), modeButton('Execution', showHappened)];
    const bar = player(view);
    const picture = element('div', {className: 'picture'}, renderer.domElement, ...present.cells.map(cell => cell.name));
    holder.append(element('div', {className: 'player', hidden: !moves}, ...present.modes),
        element('div', {className: 'stage'}, picture, layerBoxes()), bar);
    if (moves) showFrame(0);
    if (moves && view.points.length + view.surfaces.length === 0) showHappened(); else showPerceived();
    rangegrasp.shown = present;
  };

  rangegrasp.hideView = () => {
    stop();
    freeAll();
    scene = present = rangegrasp.shown = undefined;
  };
})();
