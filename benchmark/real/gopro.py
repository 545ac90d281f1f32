"""Reads the telemetry (GPMF) and the pictures of a GoPro's MP4; the pictures need the program ffmpeg."""

import struct
import subprocess

TYPES = {'b': 'b', 'B': 'B', 's': 'h', 'S': 'H', 'l': 'i', 'L': 'I', 'f': 'f', 'J': 'Q'}


def boxes(data, begin, end):
    """The boxes of an MP4 as (name, begin, end) of their contents."""
    while begin + 8 <= end:
        size, name = struct.unpack('>I4s', data[begin:begin + 8])
        head = 8
        if size == 1:
            size, head = struct.unpack('>Q', data[begin + 8:begin + 16])[0], 16
        if size < head:
            return
        yield name.decode('latin1'), begin + head, begin + size
        begin += size


def box(data, path, begin, end):
    for name in path.split('/'):
        begin, end = next((b, e) for found, b, e in boxes(data, begin, end) if found == name)
    return begin, end


def numbers(data, begin, form):
    """A table of an MP4: version and flags, the count, the rows."""
    count = struct.unpack('>I', data[begin + 4:begin + 8])[0]
    size = struct.calcsize('>' + form)
    return [struct.unpack_from('>' + form, data, begin + 8 + i * size) for i in range(count)]


def tracks(data):
    """Of each track its kind, the times between its samples in s, and where its samples are, one in each chunk."""
    movie = box(data, 'moov', 0, len(data))
    for name, begin, end in boxes(data, *movie):
        if name != 'trak':
            continue
        scale = struct.unpack('>I', data[box(data, 'mdia/mdhd', begin, end)[0] + 12:][:4])[0]
        table = box(data, 'mdia/minf/stbl', begin, end)
        kind = data[box(data, 'stsd', *table)[0] + 12:][:4].decode('latin1')
        steps = [delta / scale for count, delta in numbers(data, box(data, 'stts', *table)[0], 'II')
                 for _ in range(count)]
        sizes = box(data, 'stsz', *table)[0]
        count = struct.unpack('>I', data[sizes + 8:sizes + 12])[0]
        sizes = struct.unpack_from(f'>{count}I', data, sizes + 12)
        offsets = [offset for offset, in numbers(data, box(data, 'stco', *table)[0], 'I')]
        yield kind, steps, list(zip(offsets, sizes))


def items(data, begin, end):
    """The items of GPMF as (key, type, values or the range that holds more items)."""
    while begin + 8 <= end:
        key, kind, size, repeat = struct.unpack('>4scBH', data[begin:begin + 8])
        inside = begin + 8, begin + 8 + size * repeat
        kind = kind.decode('latin1')
        rows = None
        if kind in TYPES and size:
            width = size // struct.calcsize('>' + TYPES[kind])
            flat = struct.unpack_from(f'>{width * repeat}{TYPES[kind]}', data, inside[0])
            rows = [flat[i * width:(i + 1) * width] for i in range(repeat)]
        yield key.decode('latin1'), rows, inside
        begin = inside[0] + (size * repeat + 3) // 4 * 4


def stream(data, payloads, steps, key):
    """Times in s and values of one sensor. Its clock (STMP, in us) where there is one, else the times of the payloads;
    samples are even in between."""
    starts, blocks, clocked = [], [], True
    time = 0.0
    for (begin, size), step in zip(payloads, steps):
        for device, _, device_range in items(data, begin, begin + size):
            for kind, _, stream_range in items(data, *device_range) if device == 'DEVC' else ():
                found = {name: rows for name, rows, _ in items(data, *stream_range)} if kind == 'STRM' else {}
                if key in found:
                    clocked = clocked and 'STMP' in found
                    starts.append(found['STMP'][0][0] * 1e-6 if clocked else time)
                    scale = [value[0] for value in found.get('SCAL', [(1,)])]
                    blocks.append([tuple(v / scale[min(i, len(scale) - 1)] for i, v in enumerate(row))
                                   for row in found[key]])
        time += step
    rate = sum(len(block) for block in blocks[:-1]) / (starts[-1] - starts[0])
    samples = []
    for i, block in enumerate(blocks):
        step = (starts[i + 1] - starts[i]) / len(block) if i + 1 < len(blocks) else 1.0 / rate
        samples += [(starts[i] + j * step, row) for j, row in enumerate(block)]
    return samples


def between(samples, time):
    """Linear between neighbours; None outside."""
    low, high = 0, len(samples) - 1
    if not samples[low][0] <= time <= samples[high][0]:
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if samples[middle][0] <= time else (low, middle)
    share = (time - samples[low][0]) / (samples[high][0] - samples[low][0])
    return tuple(a + share * (b - a) for a, b in zip(samples[low][1], samples[high][1]))


def read(path, pictures):
    """Samples (stamp in ns, rate in rad/s, force in m/s^2) at the gyroscope's stamps, in the order of the file's
    channels, and pictures (stamp in ns, path), which are written to the folder."""
    data = path.read_bytes()
    found = {kind: (steps, samples) for kind, steps, samples in tracks(data)}
    steps, payloads = found['gpmd']
    force = stream(data, payloads, steps, 'ACCL')
    imu = [(round(time * 1e9), rate, between(force, time)) for time, rate in stream(data, payloads, steps, 'GYRO')]
    shutter = [time for time, _ in stream(data, payloads, steps, 'SHUT')]
    pictures.mkdir(parents=True, exist_ok=True)
    subprocess.run(['ffmpeg', '-loglevel', 'error', '-y', '-i', str(path), '-vsync', '0', '-q:v', '2',
                    str(pictures / '%06d.jpg')], check=True)
    images = sorted(pictures.glob('*.jpg'))
    return [sample for sample in imu if sample[2] is not None], [
        (round(time * 1e9), image) for time, image in zip(shutter, images)]
