// Binds and dispatches what the program made: the scene, the rewritten scene, the analysis and the builder.

const [width, height] = DATA.size;
const { scene, build, analyse } = DATA;
const element = id => document.getElementById(id);
const OVERLAY = ['#d64541', '#e8a33d', '#e8d33d', '#3aa655'];

// ---- the device

// What keeps the page from running, and what its reader can do about it.
class NotHere extends Error {
    constructor(why, ...steps) {
        super(why);
        this.steps = steps;
    }
}

async function open() {
    if (!globalThis.isSecureContext) {
        throw new NotHere('this page was not loaded from a place that the browser trusts, and WebGPU is only there for those',
            'Open the file from your disk, or serve it over https or from localhost (python3 -m http.server, then http://localhost:8000).');
    }
    if (!navigator.gpu) {
        throw new NotHere('this browser has no WebGPU',
            'Chrome and Edge have it from version 113 on, Safari from 26, Firefox from 141 on Windows and from 145 on macOS.',
            'On Linux, start Chrome with --enable-unsafe-webgpu --enable-features=Vulkan, or set chrome://flags/#enable-unsafe-webgpu.');
    }
    const adapter = await navigator.gpu.requestAdapter();
    if (!adapter) {
        throw new NotHere('this browser has WebGPU, and finds no adapter for it',
            'chrome://gpu (Firefox: about:support) tells why; often hardware acceleration is off, or the driver is blocked.',
            'On Linux, start Chrome with --enable-unsafe-webgpu --enable-features=Vulkan; without a GPU, add --use-webgpu-adapter=swiftshader.');
    }
    const software = adapter.info?.isFallbackAdapter || adapter.info?.architecture === 'swiftshader';
    // SwiftShader's timestamps end the browser's GPU process
    const timed = adapter.features.has('timestamp-query') && !software;
    const requiredFeatures = timed ? ['timestamp-query'] : [];
    const device = await adapter.requestDevice({ requiredFeatures });
    return { device, adapter, software };
}

const { BUFFER, TEXTURE } = {
    BUFFER: globalThis.GPUBufferUsage ?? {},
    TEXTURE: globalThis.GPUTextureUsage ?? {},
};

function stage(device) {
    const buffer = (size, usage) => device.createBuffer({ size: Math.ceil(size / 4) * 4, usage: usage | BUFFER.COPY_DST });
    const filled = (words, usage) => {
        const made = buffer(words.length * 4, usage);
        device.queue.writeBuffer(made, 0, new Uint32Array(words));
        return made;
    };
    const picture = () => device.createTexture({
        size: [width, height],
        format: 'rgba8unorm',
        usage: TEXTURE.STORAGE_BINDING | TEXTURE.TEXTURE_BINDING | TEXTURE.COPY_SRC,
    });
    const pipeline = (code, entryPoint) => device.createComputePipeline({
        layout: 'auto',
        compute: { module: device.createShaderModule({ code }), entryPoint },
    });
    const bind = (made, group, entries) => device.createBindGroup({
        layout: made.getBindGroupLayout(group),
        entries: entries.map(([binding, resource]) => ({ binding, resource })),
    });
    const whole = made => ({ buffer: made });

    const frame = buffer(16, BUFFER.UNIFORM);
    const [full, variable] = [picture(), picture()];
    const sri = buffer(build.sri.pitch * build.sri.height, BUFFER.STORAGE | BUFFER.COPY_SRC);
    const coords = buffer(build.words * 4, BUFFER.STORAGE);
    const settings = filled(analyse.thresholds[0].params, BUFFER.UNIFORM);

    const original = pipeline(scene.original, scene.entry);
    const rewritten = pipeline(scene.rewritten, scene.entry);
    const builder = pipeline(build.text, build.entry);
    const analyser = pipeline(analyse.text, analyse.entry);

    // of [group, binding, resource], some in one group
    const bindAll = (made, resources) => [...new Set(resources.map(([group]) => group))].map(group =>
        [group, bind(made, group, resources.filter(([of]) => of === group).map(([, ...entry]) => entry))]);
    const params = filled(scene.params, BUFFER.UNIFORM);
    const added = scene.bindings.map(([group, binding], i) => [group, binding, whole([params, coords][i])]);
    const shaded = made => [[0, 0, whole(frame)], [0, 1, made.createView()]];
    const groups = {
        original: bindAll(original, shaded(full)),
        rewritten: bindAll(rewritten, [...shaded(variable), ...added]),
        builder: bind(builder, 0, [[0, whole(filled(build.params, BUFFER.UNIFORM))], [1, whole(sri)], [2, whole(coords)]]),
        analyser: bind(analyser, 0, [
            [analyse.bindings.params, whole(settings)],
            [analyse.bindings.tables, whole(filled(analyse.tables, BUFFER.STORAGE))],
            [analyse.bindings.rates, whole(sri)],
            [analyse.bindings.colour, variable.createView()],
        ]),
    };
    return {
        full, variable, sri,
        setTime(seconds) {
            const bytes = new DataView(new ArrayBuffer(16));
            bytes.setUint32(0, width, true);
            bytes.setUint32(4, height, true);
            bytes.setFloat32(8, seconds, true);
            device.queue.writeBuffer(frame, 0, bytes.buffer);
        },
        setThreshold: step => device.queue.writeBuffer(settings, 0, new Uint32Array(analyse.thresholds[step].params)),
        setRates: bytes => device.queue.writeBuffer(sri, 0, bytes),
        shadeOriginal(pass) {
            pass.setPipeline(original);
            groups.original.forEach(([index, group]) => pass.setBindGroup(index, group));
            pass.dispatchWorkgroups(...scene.original_groups);
        },
        // Builds of both shaders that count the stores to each pixel: made for the laws alone.
        counting() {
            const counts = buffer(width * height * 4, BUFFER.STORAGE | BUFFER.COPY_SRC);
            const made = ({ text, binding }, resources, size) => {
                const counted = pipeline(text, scene.entry);
                const bound = bindAll(counted, [...resources, [...binding, whole(counts)]]);
                return pass => {
                    pass.setPipeline(counted);
                    bound.forEach(([index, group]) => pass.setBindGroup(index, group));
                    pass.dispatchWorkgroups(...size);
                };
            };
            return {
                counts,
                original: made(scene.counted.original, shaded(full), scene.original_groups),
                rewritten: made(scene.counted.rewritten, [...shaded(variable), ...added], scene.groups),
            };
        },
        analyse(pass) {
            pass.setPipeline(analyser);
            pass.setBindGroup(0, groups.analyser);
            pass.dispatchWorkgroups(...analyse.groups);
        },
        shadeRewritten(pass) {
            pass.setPipeline(builder);
            pass.setBindGroup(0, groups.builder);
            pass.dispatchWorkgroups(...build.groups);
            pass.setPipeline(rewritten);
            groups.rewritten.forEach(([index, group]) => pass.setBindGroup(index, group));
            pass.dispatchWorkgroups(...scene.groups);
        },
    };
}

async function read(device, record, bytes) {
    const buffer = device.createBuffer({ size: bytes, usage: BUFFER.COPY_DST | BUFFER.MAP_READ });
    const encoder = device.createCommandEncoder();
    record(encoder, buffer);
    device.queue.submit([encoder.finish()]);
    await buffer.mapAsync(GPUMapMode.READ);
    const copy = buffer.getMappedRange().slice(0);
    buffer.destroy();
    return copy;
}

async function readPicture(device, texture) {
    const pitch = Math.ceil(width * 4 / 256) * 256;
    const padded = await read(device, (encoder, buffer) =>
        encoder.copyTextureToBuffer({ texture }, { buffer, bytesPerRow: pitch }, [width, height]), pitch * height);
    const words = new Uint32Array(padded);
    return Uint32Array.from({ length: width * height }, (_, i) =>
        words[Math.floor(i / width) * pitch / 4 + i % width]);
}

// ---- the laws, with an oracle that knows nothing of the rewriter

// The pixel that is shaded for each pixel, as an index: the first of its block, and itself in a tile too full to save a wave.
function primaries(rateAt) {
    const first = new Uint32Array(width * height);
    const across = Math.ceil(width / build.tile[0]);
    const counts = new Uint32Array(across * Math.ceil(height / build.tile[1]));
    const tileOf = (x, y) => Math.floor(y / build.tile[1]) * across + Math.floor(x / build.tile[0]);
    for (let y = 0; y < height; y++) {
        for (let x = 0; x < width; x++) {
            const [w, h] = rateAt(x >> 1, y >> 1);
            first[y * width + x] = (y - y % h) * width + (x - x % w);
            if (x % w === 0 && y % h === 0) {
                counts[tileOf(x, y)] += 1;
            }
        }
    }
    return first.map((index, i) => counts[tileOf(i % width, Math.floor(i / width))] > build.full ? i : index);
}

function image(codeAt) {
    const bytes = new Uint8Array(build.sri.pitch * build.sri.height);
    for (let y = 0; y < build.sri.height; y++) {
        for (let x = 0; x < build.sri.width; x++) {
            bytes[y * build.sri.pitch + x] = codeAt(x, y).code;
        }
    }
    return bytes;
}

// Holds the laws, with pictures of its own, beside the ones that show.
async function laws(device) {
    const made = stage(device);
    made.setTime(1);
    const run = work => {
        const encoder = device.createCommandEncoder();
        const pass = encoder.beginComputePass();
        work(pass);
        pass.end();
        device.queue.submit([encoder.finish()]);
    };
    run(made.shadeOriginal);
    const expected = await readPicture(device, made.full);

    let seed = 0x2545f491;
    const random = build.sri.width * build.sri.height;
    const mixed = Uint8Array.from({ length: random }, () => {
        seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
        return (seed >>> 16) % build.rates.length;
    });
    const cases = build.rates.map(rate => [rate.name === '1x1' ? 'identity, 1x1' : `replication, ${rate.name}`, () => rate]);
    cases.push(['locality, rates at random', (x, y) => build.rates[mixed[y * build.sri.width + x]]]);
    const found = [];
    for (const [name, rateAt] of cases) {
        made.setRates(image(rateAt));
        run(made.shadeRewritten);
        const got = await readPicture(device, made.variable);
        const from = primaries((x, y) => rateAt(x, y).size);
        const wrong = got.reduce((sum, pixel, i) => sum + (pixel !== expected[from[i]]), 0);
        const shaded = from.reduce((sum, index, i) => sum + (index === i), 0);
        found.push({ name, wrong, shaded: shaded / from.length });
    }
    // partition: every pixel is stored to exactly as often as the original stores to its primary
    const { counts, original, rewritten } = made.counting();
    const count = async work => {
        const zeroes = device.createCommandEncoder();
        zeroes.clearBuffer(counts);
        device.queue.submit([zeroes.finish()]);
        run(work);
        return new Uint32Array(await read(device, (encoder, buffer) =>
            encoder.copyBufferToBuffer(counts, 0, buffer, 0, counts.size), counts.size));
    };
    const stored = await count(original);
    const rateAt = (x, y) => build.rates[mixed[y * build.sri.width + x]];
    const [from, copied] = [primaries((x, y) => rateAt(x, y).size), await count(rewritten)];
    const wrong = copied.reduce((sum, times, i) => sum + (times !== stored[from[i]]), 0);
    found.stores = copied.reduce((sum, times) => sum + times, 0);
    found.push({
        name: 'partition, rates at random', wrong,
        shaded: from.reduce((sum, index, i) => sum + (index === i), 0) / from.length,
    });
    // a picture of one colour would hold any law
    found.colours = new Set(expected).size;
    return found;
}

// ---- what shows

const PRESENT = `
@group(0) @binding(0) var full: texture_2d<f32>;
@group(0) @binding(1) var variable: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> sri: array<u32>;
struct Shown { split: f32, overlay: u32, pitch: u32, room: u32 }
@group(0) @binding(3) var<uniform> shown: Shown;
@vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment fn show(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(at.xy);
    if abs(at.x - shown.split) < 1.0 { return vec4f(1.0); }
    if at.x < shown.split { return textureLoad(full, pixel, 0); }
    let color = textureLoad(variable, pixel, 0).rgb;
    let quad = pixel / 2u;
    let code = (sri[quad.y * shown.pitch + quad.x / 4u] >> (8u * (quad.x % 4u))) & 15u;
    var tints = array<vec3f, 4>(${OVERLAY.map(hex => `vec3f(${[1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16) / 255 + 1e-4).join(',')})`).join(',')});
    let tint = tints[min(code & 3u, 1u) + 2u * min(code >> 2u, 1u)];
    return vec4f(mix(color, tint, select(0.0, 0.45, shown.overlay == 1u)), 1.0);
}`;

function row(table, name, value, kind) {
    const line = table.insertRow();
    line.insertCell().textContent = name;
    const cell = line.insertCell();
    cell.textContent = value;
    cell.className = kind ?? '';
}

// Presents by the GPU: a canvas that WebGPU draws to.
function screen(device, made) {
    const context = element('canvas').getContext('webgpu');
    const format = navigator.gpu.getPreferredCanvasFormat();
    context.configure({ device, format });
    const module = device.createShaderModule({ code: PRESENT });
    const pipeline = device.createRenderPipeline({
        layout: 'auto',
        vertex: { module, entryPoint: 'corner' },
        fragment: { module, entryPoint: 'show', targets: [{ format }] },
    });
    const shown = device.createBuffer({ size: 16, usage: BUFFER.UNIFORM | BUFFER.COPY_DST });
    const group = device.createBindGroup({
        layout: pipeline.getBindGroupLayout(0),
        entries: [made.full.createView(), made.variable.createView(), { buffer: made.sri }, { buffer: shown }]
            .map((resource, binding) => ({ binding, resource })),
    });
    return (split, overlay) => {
        device.queue.writeBuffer(shown, 0, new Float32Array([split]));
        device.queue.writeBuffer(shown, 4, new Uint32Array([overlay ? 1 : 0, build.sri.pitch / 4, 0]));
        const encoder = device.createCommandEncoder();
        const drawn = encoder.beginRenderPass({
            colorAttachments: [{ view: context.getCurrentTexture().createView(), loadOp: 'clear', storeOp: 'store' }],
        });
        drawn.setPipeline(pipeline);
        drawn.setBindGroup(0, group);
        drawn.draw(3);
        drawn.end();
        device.queue.submit([encoder.finish()]);
    };
}

// Presents by the CPU: a software adapter has no screen to draw to in every browser.
function paper(device, made) {
    const context = element('canvas').getContext('2d');
    const tints = OVERLAY.map(hex => [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16)));
    return async (split, overlay) => {
        const [full, variable] = [await readPicture(device, made.full), await readPicture(device, made.variable)];
        const codes = await readRates(device, made);
        const painted = new ImageData(width, height);
        const pixels = new Uint32Array(painted.data.buffer);
        pixels.set(variable);
        for (let i = 0; i < pixels.length; i++) {
            const [x, y] = [i % width, Math.floor(i / width)];
            if (Math.abs(x + 0.5 - split) < 1) {
                pixels[i] = 0xffffffff;
            } else if (x < split) {
                pixels[i] = full[i];
            } else if (overlay) {
                const code = codes[(y >> 1) * build.sri.pitch + (x >> 1)];
                const tint = tints[Math.min(code & 3, 1) + 2 * Math.min(code >> 2, 1)];
                tint.forEach((value, c) => painted.data[4 * i + c] = 0.55 * painted.data[4 * i + c] + 0.45 * value);
            }
        }
        context.putImageData(painted, 0, 0);
    };
}

async function readRates(device, made) {
    return new Uint8Array(await read(device, (encoder, buffer) =>
        encoder.copyBufferToBuffer(made.sri, 0, buffer, 0, buffer.size), build.sri.pitch * build.sri.height));
}

async function show(device, made, software) {
    const canvas = element('canvas');
    [canvas.width, canvas.height] = [width, height];
    const present = software ? paper(device, made) : screen(device, made);
    const timed = device.features.has('timestamp-query');
    const queries = timed && device.createQuerySet({ type: 'timestamp', count: 6 });
    const stamps = timed && device.createBuffer({ size: 48, usage: BUFFER.QUERY_RESOLVE | BUFFER.COPY_SRC });
    const pass = (encoder, index) => encoder.beginComputePass(timed ? {
        timestampWrites: { querySet: queries, beginningOfPassWriteIndex: 2 * index, endOfPassWriteIndex: 2 * index + 1 },
    } : {});

    let split = width / 2;
    const figure = element('figure');
    const move = to => {
        split = Math.min(Math.max(to, 0), width);
        const percent = Math.round(100 * split / width);
        figure.setAttribute('aria-valuenow', percent);
        figure.setAttribute('aria-valuetext', `${percent} % original`);
    };
    move(split);
    const drag = event => {
        const box = figure.getBoundingClientRect();
        move((event.clientX - box.left) / box.width * width);
    };
    figure.addEventListener('pointerdown', event => {
        figure.setPointerCapture(event.pointerId);
        drag(event);
    });
    figure.addEventListener('pointermove', event => figure.hasPointerCapture(event.pointerId) && drag(event));
    figure.addEventListener('keydown', event => {
        const step = (event.shiftKey ? 0.1 : 0.01) * width;
        const to = {
            ArrowLeft: split - step, ArrowDown: split - step, ArrowRight: split + step, ArrowUp: split + step,
            PageDown: split - width / 10, PageUp: split + width / 10, Home: 0, End: width,
        }[event.key];
        if (to !== undefined) {
            event.preventDefault();
            move(to);
        }
    });

    const history = [[], [], []];
    const middle = values => [...values].sort((a, b) => a - b)[values.length >> 1];
    let [frames, seconds, last] = [0, 1, undefined];
    let shown;
    const first = new Promise(resolve => shown = resolve);
    const next = async now => {
        const moving = element('moving').checked;
        seconds += moving && last !== undefined ? Math.min(now - last, 100) / 1000 : 0;
        last = now;
        made.setTime(seconds);
        made.setThreshold(element('threshold').valueAsNumber);
        element('t').value = analyse.thresholds[element('threshold').valueAsNumber].t.toFixed(2);
        const choice = build.rates.find(rate => rate.name === element('rates').value);
        if (choice) {
            made.setRates(image(() => choice));
        }
        const encoder = device.createCommandEncoder();
        let open = pass(encoder, 0);
        made.shadeOriginal(open);
        open.end();
        open = pass(encoder, 1);
        if (!choice && frames > 0) {
            made.analyse(open);
        }
        open.end();
        open = pass(encoder, 2);
        made.shadeRewritten(open);
        open.end();
        if (timed) {
            encoder.resolveQuerySet(queries, 0, 6, stamps, 0);
        }
        device.queue.submit([encoder.finish()]);
        await present(split, element('overlay').checked);
        shown();
        if (frames % 8 === 1) {
            await figures();
        }
        frames += 1;
        requestAnimationFrame(next);
    };
    const figures = async () => {
        const bytes = await readRates(device, made);
        const sizes = new Map(build.rates.map(rate => [rate.code, rate.size]));
        const from = primaries((x, y) => sizes.get(bytes[y * build.sri.pitch + x]) ?? [1, 1]);
        const share = from.reduce((sum, index, i) => sum + (index === i), 0) / from.length;
        const table = element('figures');
        table.replaceChildren();
        row(table, 'pixels shaded', `${(100 * share).toFixed(1)} %`);
        if (timed) {
            const times = new BigUint64Array(await read(device, (encoder, buffer) =>
                encoder.copyBufferToBuffer(stamps, 0, buffer, 0, 48), 48));
            history.forEach((values, i) => {
                values.push(Number(times[2 * i + 1] - times[2 * i]) / 1e6);
                values.splice(0, values.length - 15);
            });
        } else {
            const works = [made.shadeOriginal, made.analyse, made.shadeRewritten];
            for (const [i, work] of works.entries()) {
                if (i !== 1 || !element('rates').selectedIndex) {
                    history[i].push(await clocked(work));
                    history[i].splice(0, history[i].length - 15);
                }
            }
        }
        const [full, analysed, variable] = history.map(middle);
        const by = timed ? '' : ', by the host\'s clock';
        row(table, `original shader${by}`, `${full.toFixed(3)} ms`);
        row(table, `rewritten shader and its coordinates${by}`, `${variable.toFixed(3)} ms`);
        if (analysed !== undefined) {
            row(table, `analysis${by}`, `${analysed.toFixed(3)} ms`);
        }
    };
    // The time of a submission, its latency included.
    const clocked = async work => {
        await device.queue.onSubmittedWorkDone();
        const start = performance.now();
        const encoder = device.createCommandEncoder();
        const open = encoder.beginComputePass();
        work(open);
        open.end();
        device.queue.submit([encoder.finish()]);
        await device.queue.onSubmittedWorkDone();
        return performance.now() - start;
    };
    requestAnimationFrame(next);
    await first;
}

// ---- the page

async function main() {
    element('original').textContent = scene.original;
    element('rewritten').textContent = scene.rewritten;
    Object.assign(element('threshold'), { min: 0, max: analyse.thresholds.length - 1, value: 10 });
    build.rates.forEach(rate => element('rates').add(new Option(`${rate.name} everywhere`, rate.name)));
    element('keys').innerHTML = build.rates.map((rate, i) => `<span class="nobr"><span class="key" style="background:${OVERLAY[i]}"></span>${rate.name}</span>`).join(' ');

    const { device, adapter, software } = await open();
    const problems = [];
    device.addEventListener('uncapturederror', event => problems.push(event.error.message));
    await show(device, stage(device), software);
    const order = ['picture'];
    const table = element('laws');
    table.rows[0].cells[0].textContent = 'being held …';
    const found = await laws(device);
    order.push('laws');
    table.replaceChildren();
    for (const { name, wrong, shaded } of found) {
        row(table, `${name}, ${(100 * shaded).toFixed(1)} % shaded`, wrong === 0 ? 'held, bit for bit' : `${wrong} pixels differ`, wrong === 0 ? 'held' : 'broken');
    }
    const info = adapter.info ?? {};
    row(table, 'on', [info.vendor, info.architecture, info.description].filter(Boolean).join(' ') || 'an adapter without a name');
    return { laws: found, colours: found.colours, stores: found.stores, order, problems };
}

let outcome;
try {
    outcome = await main();
} catch (error) {
    const why = error instanceof NotHere ? error.message : String(error);
    element('laws').replaceChildren();
    row(element('laws'), why, 'not held', 'broken');
    element('figure').hidden = true;
    element('help').hidden = false;
    element('why').textContent = `Nothing runs here: ${why}.`;
    element('steps').replaceChildren(...(error.steps ?? []).map(step =>
        Object.assign(document.createElement('li'), { textContent: step })));
    outcome = { broken: why, steps: error.steps ?? [] };
}
// where a test serves the page, it wants to be told
if (location.search === '?answer') {
    await fetch('/answer', { method: 'POST', body: JSON.stringify(outcome) });
}
