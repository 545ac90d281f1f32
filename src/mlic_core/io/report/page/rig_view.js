'use strict';

// Draws the rig in three dimensions, with three.js, into `place`. False where the browser cannot.
function drawRig(data, place) {
  if (typeof THREE === 'undefined' || !document.createElement('canvas').getContext('webgl')) return false;

  const extent = data.extent;
  const length = 0.12 * extent;  // of a sensor's axes
  const cut = 0.12 * extent;     // no semi-axis of an ellipsoid is longer

  const stage = document.createElement('div');
  stage.className = 'stage';
  stage.tabIndex = 0;
  stage.setAttribute('role', 'img');
  stage.setAttribute('aria-label', 'the rig in three dimensions, drag to turn');
  const controls = document.createElement('div');
  controls.className = 'controls';
  const note = document.createElement('p');
  note.className = 'note';
  const held = data.sensors.some((sensor) => sensor.translation_observable.includes(false));
  note.textContent = `Drag to turn. Ellipsoids: one sigma of the translation, ${data.ellipsoid_scale === 1 ? 'at its size' : `enlarged ${data.ellipsoid_scale} times`}` +
    (held ? `; where a direction is unobservable they are cut at ${(1000 * cut / data.ellipsoid_scale).toPrecision(2)} mm.` : '.');
  place.append(controls, stage, note);
  place.hidden = false;

  const renderer = new THREE.WebGLRenderer({alpha: true, antialias: true, preserveDrawingBuffer: true});
  renderer.setClearColor(0, 0);
  stage.append(renderer.domElement);
  const scene = new THREE.Scene();

  // All is placed in the root's frame and seen along the vehicle's axes: forward, left, up.
  const rig = new THREE.Group();
  const [f, l, u] = data.view;
  rig.matrix.set(...f, 0, ...l, 0, ...u, 0, 0, 0, 0, 1);
  rig.matrixAutoUpdate = false;
  scene.add(rig);
  const guesses = new THREE.Group(), ellipsoids = new THREE.Group();
  rig.add(guesses, ellipsoids);

  const vector = (values) => new THREE.Vector3(...values);
  const line = (points, colour, opacity, kind = THREE.Line) => {
    const geometry = new THREE.BufferGeometry().setFromPoints(points);
    return new kind(geometry, new THREE.LineBasicMaterial({color: colour, transparent: true, opacity}));
  };
  const COLOURS = [0xd62728, 0x2ca02c, 0x1f77ff];  // x, y, z

  // The frame of a sensor; thin lines where it is a guess.
  const axes = (size, guess) => {
    const group = new THREE.Group();
    COLOURS.forEach((colour, k) => {
      const direction = new THREE.Vector3().setComponent(k, 1);
      if (guess) {
        group.add(line([new THREE.Vector3(), direction.clone().multiplyScalar(size)], colour, 0.7));
        return;
      }
      const rod = new THREE.Mesh(new THREE.CylinderGeometry(0.045 * size, 0.045 * size, size, 8),
                                 new THREE.MeshBasicMaterial({color: colour}));
      rod.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), direction);
      rod.position.copy(direction).multiplyScalar(0.5 * size);
      group.add(rod);
    });
    return group;
  };
  const at = (group, pose) => {
    group.position.set(...pose.translation);
    group.quaternion.set(...pose.rotation);
    return group;
  };

  // What a camera sees: its image's edge as a cone.
  const cone = (sensor, opacity) => {
    const group = new THREE.Group(), edge = sensor.outline.map((each) => vector(each).multiplyScalar(1.6 * length));
    if (edge.length < 4) return group;
    group.add(line(edge, sensor.color, opacity, THREE.LineLoop));
    for (let i = 0; i < edge.length; i += Math.ceil(edge.length / 4)) {
      group.add(line([new THREE.Vector3(), edge[i]], sensor.color, opacity));
    }
    return group;
  };

  const labels = [];
  const label = (text, position, colour) => {
    const span = document.createElement('span');
    span.textContent = text;
    span.style.color = `color-mix(in srgb, ${colour} 65%, var(--ink))`;
    stage.append(span);
    labels.push({span, position});
  };

  rig.add(axes(1.3 * length, false));
  label(data.root, new THREE.Vector3(), 'var(--ink)');
  for (const sensor of data.sensors) {
    const pose = sensor.T_root_sensor, group = at(axes(length, false), pose);
    const ball = new THREE.Mesh(new THREE.SphereGeometry(0.14 * length, 16, 12), new THREE.MeshBasicMaterial({color: sensor.color}));
    group.add(ball, cone(sensor, 0.9));
    if (sensor.type === 'lidar') {
      const ring = [...Array(48).keys()].map((i) => new THREE.Vector3(
        0.5 * length * Math.cos(i * Math.PI / 24), 0.5 * length * Math.sin(i * Math.PI / 24), 0));
      group.add(line(ring, sensor.color, 0.9, THREE.LineLoop));
    }
    rig.add(group);
    label(sensor.name, vector(pose.translation), sensor.color);
    if (sensor.guess) {
      guesses.add(at(axes(length, true), sensor.guess).add(cone(sensor, 0.3)));
      guesses.add(line([vector(sensor.guess.translation), vector(pose.translation)], sensor.color, 0.9));
    }
    const ellipsoid = new THREE.Mesh(
      new THREE.SphereGeometry(1, 24, 16),
      new THREE.MeshBasicMaterial({color: sensor.color, transparent: true, opacity: 0.28, depthWrite: false}));
    ellipsoid.scale.set(...sensor.sigma.translation.map(
      (sigma) => Math.max(1e-6, Math.min(cut, data.ellipsoid_scale * (sigma === null ? cut : sigma)))));
    ellipsoid.position.set(...pose.translation);
    ellipsoids.add(ellipsoid);
  }

  scene.updateMatrixWorld(true);
  const box = new THREE.Box3();
  for (const each of labels) box.expandByPoint(each.position.clone().applyMatrix4(rig.matrix));
  const middle = box.getCenter(new THREE.Vector3());
  const reach = 0.5 * box.getSize(new THREE.Vector3()).length() + 1.5 * length;

  const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 40 * reach);
  camera.up.set(0, 0, 1);
  const view = {azimuth: 35, elevation: 28, zoom: 1};  // degrees: where one looks from, 0 in front

  const place_labels = (width, height) => {
    const taken = [];
    const shown = labels.map((each) => {
      const p = each.position.clone().applyMatrix4(rig.matrix).project(camera);
      return {span: each.span, x: 0.5 * (p.x + 1) * width + 8, y: 0.5 * (1 - p.y) * height - 18};
    }).sort((a, b) => a.y - b.y);
    for (const each of shown) {
      const w = each.span.offsetWidth, h = each.span.offsetHeight;
      let x = Math.max(0, Math.min(width - w, each.x)), y = each.y;
      const hits = () => taken.find((t) => x < t.x + t.w && t.x < x + w && y < t.y + t.h && t.y < y + h);
      for (let hit = hits(); hit; hit = hits()) y = hit.y + hit.h;
      taken.push({x, y, w, h});
      each.span.style.transform = `translate(${x}px,${y}px)`;
    }
  };

  const point_camera = () => {
    const a = view.azimuth * Math.PI / 180, e = view.elevation * Math.PI / 180;
    camera.position.set(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)).multiplyScalar(20 * reach).add(middle);
    camera.lookAt(middle);
    camera.updateMatrixWorld(true);
  };

  // As large as the sensors allow from where one looks.
  const fit = () => {
    point_camera();
    const aspect = stage.clientWidth / stage.clientHeight;
    let wanted = 2.2 * length;
    const shown = data.sensors.filter((sensor) => sensor.guess).map((sensor) => vector(sensor.guess.translation));
    for (const position of [...labels.map((each) => each.position), ...shown]) {
      const p = position.clone().applyMatrix4(rig.matrix).applyMatrix4(camera.matrixWorldInverse);
      wanted = Math.max(wanted, Math.abs(p.y) + 2.2 * length, (Math.abs(p.x) + 2.6 * length) / aspect);
    }
    view.zoom = reach / wanted;
  };

  const render = () => {
    const width = stage.clientWidth, height = stage.clientHeight;
    if (!width || !height) return;
    const half = reach / view.zoom;  // of the picture's height
    camera.left = -half * width / height;
    camera.right = -camera.left;
    camera.top = half;
    camera.bottom = -half;
    point_camera();
    camera.updateProjectionMatrix();
    renderer.setPixelRatio(devicePixelRatio);
    renderer.setSize(width, height);
    renderer.render(scene, camera);
    place_labels(width, height);
    stage.dataset.view = `${view.azimuth.toFixed(0)} ${view.elevation.toFixed(0)}`;
  };

  const turn = (right, up) => {
    view.azimuth = (view.azimuth - right + 360) % 360;
    view.elevation = Math.max(-89.9, Math.min(89.9, view.elevation + up));
    render();
  };
  let last = null;
  stage.addEventListener('pointerdown', (event) => {
    last = [event.clientX, event.clientY];
    stage.setPointerCapture(event.pointerId);
  });
  stage.addEventListener('pointermove', (event) => {
    if (!last || !event.buttons) return;
    turn(0.4 * (event.clientX - last[0]), 0.4 * (event.clientY - last[1]));
    last = [event.clientX, event.clientY];
  });
  stage.addEventListener('keydown', (event) => {
    const by = {ArrowLeft: [-5, 0], ArrowRight: [5, 0], ArrowUp: [0, 5], ArrowDown: [0, -5]}[event.key];
    if (!by) return;
    event.preventDefault();
    turn(...by);
  });

  const button = (text, act) => {
    const made = document.createElement('button');
    made.type = 'button';
    made.textContent = text;
    made.addEventListener('click', () => {
      act();
      render();
    });
    controls.append(made);
  };
  const look = (text, azimuth, elevation) => button(text, () => {
    Object.assign(view, {azimuth, elevation});
    fit();
  });
  look('oblique', 35, 28);
  look('from above', 180, 89.9);
  look('from the left', 90, 0);
  look('from the front', 0, 0);
  button('+', () => { view.zoom = Math.min(20, 1.25 * view.zoom); });
  button('−', () => { view.zoom = Math.max(0.2, view.zoom / 1.25); });
  const toggle = (text, show) => {
    const input = document.createElement('input'), made = document.createElement('label');
    input.type = 'checkbox';
    input.checked = true;
    input.addEventListener('change', () => {
      show(input.checked);
      render();
    });
    made.append(input, ' ' + text);
    controls.append(made);
  };
  if (guesses.children.length) toggle('guess of the rig file', (on) => { guesses.visible = on; });
  toggle('sigmas', (on) => { ellipsoids.visible = on; });
  toggle('names', (on) => labels.forEach((each) => { each.span.hidden = !on; }));

  fit();
  render();
  new ResizeObserver(render).observe(stage);
  return true;
}
