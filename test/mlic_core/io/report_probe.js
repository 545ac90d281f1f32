// Uses the report as a reader would and tells the page around it what it saw, NAME=VALUE in lines.
(() => {
  const seen = {};
  const fire = (target, type, properties = {}) =>
    target.dispatchEvent(Object.assign(new Event(type, {bubbles: true}), properties));

  document.querySelectorAll('details').forEach((each) => { each.open = true; });
  seen.width = innerWidth;
  seen.overflow = document.documentElement.scrollWidth - innerWidth;
  // Nothing may stick out of its section, but what scrolls there.
  seen.sticking_out = [...document.querySelectorAll('section *')].filter((each) => {
    if (each.closest('.wide') || each.closest('.stage') || each.closest('svg')) return false;
    const box = each.getBoundingClientRect();
    return box.width > 0 && box.right > each.closest('section').getBoundingClientRect().right + 1;
  }).map((each) => each.tagName + '.' + each.className).join(' ');

  const compare = document.querySelector('.compare');
  const clip = () => getComputedStyle(compare.querySelector('.before')).clipPath;
  seen.clip_before = clip();
  const slider = compare.querySelector('input');
  slider.value = 80;
  fire(slider, 'input');
  seen.clip_after = clip();

  const reference = document.getElementById('reference'), clock = document.getElementById('clock');
  seen.references = [...reference.options].map((each) => each.textContent).join(', ');
  reference.value = '2';
  fire(reference, 'change');
  clock.value = '2';
  fire(clock, 'change');
  const rows = [...document.querySelectorAll('#frame-table tbody tr')];
  seen.row = [...rows[1].cells].map((each) => each.textContent).join('|');
  seen.publisher = document.getElementById('publishers').textContent.split('\n')[1];
  reference.value = reference.options.length - 1;
  fire(reference, 'change');
  const z = document.getElementById('other-z');
  z.value = '1.5';
  fire(z, 'input');
  seen.about_base = document.getElementById('publishers').textContent.split('\n')[0];

  const stage = document.querySelector('.stage');
  seen.turnable = stage !== null;
  if (stage) {
    const before = stage.dataset.view, picture = stage.querySelector('canvas').toDataURL();
    [...document.querySelectorAll('.controls button')].find((each) => each.textContent === 'from above').click();
    seen.turned = before !== stage.dataset.view && picture !== stage.querySelector('canvas').toDataURL();
    seen.still_hidden = document.getElementById('rig-still').hidden;
  }
  seen.errors = window.probeErrors.join(' / ');
  parent.postMessage('\n' + Object.entries(seen).map(([name, value]) => `${name}=${value}`).join('\n') + '\n', '*');
})();
