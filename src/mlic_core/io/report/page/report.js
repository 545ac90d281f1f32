'use strict';

// What the report's reader can choose. All numbers come from the JSON in the page.
(() => {
  const data = JSON.parse(document.getElementById('calibration').textContent);

  // Quaternions are x, y, z, w; poses {translation, rotation} map points of the second frame into the first.
  const multiply = ([ax, ay, az, aw], [bx, by, bz, bw]) => [
    aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz];
  const conjugate = ([x, y, z, w]) => [-x, -y, -z, w];
  const rotate = (q, v) => multiply(multiply(q, [...v, 0]), conjugate(q)).slice(0, 3);
  const add = (a, b) => a.map((value, i) => value + b[i]);
  const compose = (a, b) => ({
    translation: add(rotate(a.rotation, b.translation), a.translation), rotation: multiply(a.rotation, b.rotation)});
  const inverse = (pose) => ({
    translation: rotate(conjugate(pose.rotation), pose.translation).map((value) => -value),
    rotation: conjugate(pose.rotation)});
  const identity = {translation: [0, 0, 0], rotation: [0, 0, 0, 1]};
  const positive = (q) => (q[3] < 0 ? q.map((value) => -value) : q);

  // About fixed axes, as in URDF; degrees.
  const toRollPitchYaw = ([x, y, z, w]) => [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x)))),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))].map((angle) => angle * 180 / Math.PI);
  const fromRollPitchYaw = (degrees) => {
    const turn = (axis) => {
      const half = degrees[axis] * Math.PI / 360, q = [0, 0, 0, Math.cos(half)];
      q[axis] = Math.sin(half);
      return q;
    };
    return multiply(turn(2), multiply(turn(1), turn(0)));
  };

  // Without the sign of a negative zero.
  const fixed = (value, decimals) => {
    const text = value.toFixed(decimals);
    return Number(text) === 0 ? text.replace('-', '') : text;
  };
  const shellQuoted = (text) => (/^[\w./-]+$/.test(text) ? text : `'${text.replace(/'/g, `'\\''`)}'`);

  const element = (name, properties = {}, ...children) => {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...children);
    return made;
  };

  const addCopyButton = (pre) => {
    const button = element('button', {type: 'button', textContent: 'copy'});
    button.addEventListener('click', () => {
      const text = pre.querySelector('code').textContent;
      const done = () => {
        button.textContent = 'copied';
        setTimeout(() => { button.textContent = 'copy'; }, 1500);
      };
      // A page from a file may have no clipboard: then the text is marked, to be copied by key.
      const mark = () => getSelection().selectAllChildren(pre.querySelector('code'));
      if (navigator.clipboard) navigator.clipboard.writeText(text).then(done, mark); else mark();
    });
    pre.append(button);
  };

  const frames = [{name: data.root_name, frame: data.root, T_root_sensor: identity, time_offset: 0}, ...data.sensors];

  // The largest sigmas of two sensors to each other, as in the matrix of pairs.
  const sigmaOf = (a, b) => {
    const root = frames[0].name;
    const sensor = a.name === root ? b : b.name === root ? a : null;
    const pair = data.pairs.find(
      (each) => (each.a === a.name && each.b === b.name) || (each.a === b.name && each.b === a.name));
    return sensor && sensor.sigma ? sensor.sigma : pair ? pair.sigma : null;
  };

  const showFrames = (place) => {
    const OTHER = frames.length;
    const choose = (label, options) => {
      const select = element('select');
      options.forEach((text, i) => select.append(element('option', {value: i, textContent: text})));
      return [select, element('label', {}, label + ' ', select)];
    };
    const label = (each) => (each.frame === each.name ? each.name : `${each.name} (${each.frame})`);
    const [reference, referenceLabel] = choose('poses about', [...frames.map(label), 'another frame ...']);
    reference.id = 'reference';
    const clocked = frames.filter((each) => each.time_offset !== null);
    const [clock, clockLabel] = choose('time offsets to the clock of', clocked.map((each) => each.name));
    clock.id = 'clock';
    const field = (id, text, value) => {
      const input = element('input', {type: 'text', id, value, size: 8});
      input.addEventListener('input', () => update());
      return [input, element('label', {}, text + ' ', input)];
    };
    const fields = [['other-name', 'frame', 'base_link'], ['other-x', 'x, m', '0'], ['other-y', 'y', '0'],
                    ['other-z', 'z', '0'], ['other-roll', 'roll, °', '0'], ['other-pitch', 'pitch', '0'],
                    ['other-yaw', 'yaw', '0']].map((each) => field(...each));
    const other = element('div', {className: 'fields', hidden: true},
                          `where ${frames[0].name} stands in it:`, ...fields.map(([, each]) => each));
    const controls = element('div', {className: 'controls'}, referenceLabel, clockLabel, other);
    const body = element('tbody');
    const heads = ['sensor', 'x, m', 'y, m', 'z, m', 'roll, °', 'pitch, °', 'yaw, °', 'qx, qy, qz, qw', 'time offset, ms',
                   'largest σ'];
    const table = element('table', {className: 'stack', id: 'frame-table'},
                          element('thead', {}, element('tr', {}, ...heads.map((text) => element('th', {textContent: text})))),
                          body);
    const code = element('code', {id: 'publishers'});
    const pre = element('pre', {className: 'copy'}, code);
    addCopyButton(pre);

    const update = () => {
      const chosen = Number(reference.value), byHand = chosen === OTHER;
      other.hidden = !byHand;
      const values = fields.map(([input]) => input.value);
      const numbers = values.slice(1).map((text) => Number(text) || 0);
      const T_ref_root = byHand
        ? {translation: numbers.slice(0, 3), rotation: fromRollPitchYaw(numbers.slice(3))}
        : inverse(frames[chosen].T_root_sensor);
      const parent = byHand ? values[0] || 'base_link' : frames[chosen].frame;
      const offset = clocked[Number(clock.value)].time_offset;
      const lines = [];
      body.replaceChildren();
      frames.forEach((each, i) => {
        if (i === chosen) return;
        const pose = compose(T_ref_root, each.T_root_sensor), q = positive(pose.rotation);
        const sigma = byHand ? null : sigmaOf(frames[chosen], each);
        const cells = [
          each.name, ...pose.translation.map((value) => fixed(value, 4)),
          ...toRollPitchYaw(q).map((value) => fixed(value, 3)), q.map((value) => fixed(value, 6)).join(', '),
          each.time_offset === null ? '' : fixed(1e3 * (each.time_offset - offset), 3),
          sigma ? `${fixed(Math.max(...sigma.rotation_deg), 4)}°, ${fixed(1e3 * Math.max(...sigma.translation), 1)} mm` : ''];
        const row = element('tr', {}, ...cells.map((text, k) => element('td', {textContent: text, className: k ? 'n' : ''})));
        [...row.cells].forEach((cell, k) => { if (k) cell.dataset.label = heads[k]; });
        body.append(row);
        const pose_text = [...pose.translation, ...q].map((value) => fixed(value, 9)).join(' ');
        lines.push('rosrun tf2_ros static_transform_publisher ' +
                   `${pose_text} ${shellQuoted(parent)} ${shellQuoted(each.frame)}`);
      });
      code.textContent = lines.join('\n');
    };
    reference.addEventListener('change', update);
    clock.addEventListener('change', update);
    place.append(
      controls, element('div', {className: 'wide'}, table),
      element('p', {className: 'note', textContent:
        'T_reference_sensor: p_reference = T p_sensor. Time offsets: t_clock = t_sensor + offset' +
        ' (of clocks that drift: in the middle of the drive). Largest σ: of rotation and of translation, unobservable directions included.'}),
      element('details', {}, element('summary', {textContent: 'the same as commands'}), pre));
    update();
  };

  const slide = (figure) => {
    const pictures = figure.querySelector('.pictures'), input = figure.querySelector('input');
    const move = (share) => {
      input.value = share;
      pictures.style.setProperty('--at', `${share}%`);
    };
    input.addEventListener('input', () => move(input.value));
    const drag = (event) => {
      const box = pictures.getBoundingClientRect();
      move(Math.max(0, Math.min(100, 100 * (event.clientX - box.left) / box.width)));
    };
    pictures.addEventListener('pointerdown', (event) => {
      pictures.setPointerCapture(event.pointerId);
      drag(event);
    });
    pictures.addEventListener('pointermove', (event) => { if (event.buttons) drag(event); });
    move(50);
  };

  document.querySelectorAll('pre.copy').forEach(addCopyButton);
  const place = document.getElementById('frame-choice');
  if (place) showFrames(place);
  document.querySelectorAll('.compare').forEach(slide);
  document.querySelectorAll('img.enlarge').forEach((image) => {
    image.addEventListener('click', () => image.closest('.card').classList.toggle('large'));
  });
  const view = document.getElementById('rig-view');
  if (view && drawRig(data, view)) document.getElementById('rig-still').hidden = true;

  // What is folded is printed, but for the log.
  addEventListener('beforeprint', () => {
    document.querySelectorAll('section:not(#log) details').forEach((each) => { each.open = true; });
  });
})();
