// The map of a report.  Its data stand in the element "map-data"; nothing is loaded from elsewhere.
// Places are in cells of the grid: x from the west, y from the north.
"use strict";
(async () => {
  const RELEASE = "#d4006a", CONTOUR = "#4a3b28", INK = "#222";
  const data = JSON.parse(document.getElementById("map-data").textContent);
  const { grid, words } = data;
  const root = document.getElementById("map");
  const canvas = root.querySelector("canvas"), pen = canvas.getContext("2d");
  const element = (name) => root.querySelector(`[data-part="${name}"]`);
  if (typeof DecompressionStream === "undefined") {
    element("readout").textContent = words.unsupported;
    return;
  }

  // ---- data

  async function unpacked({ low, step, values }) {
    const bytes = Uint8Array.from(atob(values), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const view = new DataView(await new Response(stream).arrayBuffer());
    const numbers = new Uint16Array(grid.columns * grid.rows);
    for (let k = 0; k < numbers.length; k++) numbers[k] = view.getUint16(2 * k, true);
    const at = (cell) => (numbers[cell] === 0 ? NaN : low + (numbers[cell] - 1) * step);
    return { numbers, at };
  }

  function colorOf(layer, value) {
    const last = layer.colors.length - 1;
    for (let k = 0; k < last; k++) if (value < layer.bounds[k + 1]) return layer.colors[k];
    return layer.colors[last];
  }

  // one pixel a cell
  function painted(layer, values) {
    const picture = document.createElement("canvas");
    [picture.width, picture.height] = [grid.columns, grid.rows];
    const own = picture.getContext("2d"), image = own.createImageData(grid.columns, grid.rows);
    values.numbers.forEach((number, k) => {
      if (number === 0) return;
      const color = parseInt(colorOf(layer, values.at(k)).slice(1), 16);
      image.data.set([color >> 16, (color >> 8) & 255, color & 255, 255], 4 * k);
    });
    own.putImageData(image, 0, 0);
    return picture;
  }

  const elevation = await unpacked(data.elevation);
  const layers = [];
  for (const layer of data.layers) layers.push({ ...layer, values: await unpacked(layer.data) });
  const frames = data.frames && { ...data.frames, all: [], frame: 0 };
  if (frames) for (const packed of frames.data) frames.all.push(await unpacked(packed));
  for (const layer of layers) layer.picture = painted(layer, layer.values);
  const relief = new Image();
  relief.src = data.relief;
  await relief.decode();

  // ---- what is shown, and from where

  let current = layers[0] || frames || null;
  let opacity = 0.85, picked = null;
  const view = { scale: 1, x: 0, y: 0 }; // pixels a cell, and where the north-west corner is

  function showFrame(number) {
    frames.frame = number;
    frames.values = frames.all[number];
    frames.picture = painted(frames, frames.values);
  }
  if (frames) showFrame(0);

  function showAll() {
    const { clientWidth: width, clientHeight: height } = canvas;
    view.scale = Math.min(width / grid.columns, height / grid.rows);
    view.x = 0.5 * (width - view.scale * grid.columns);
    view.y = 0.5 * (height - view.scale * grid.rows);
  }

  const toPixels = ([x, y]) => [view.x + view.scale * x, view.y + view.scale * y];
  const toCells = (x, y) => [(x - view.x) / view.scale, (y - view.y) / view.scale];

  function cellAt([x, y]) {
    const [column, row] = [Math.floor(x), Math.floor(y)];
    const inside = column >= 0 && row >= 0 && column < grid.columns && row < grid.rows;
    return inside ? row * grid.columns + column : -1;
  }

  // ---- drawing

  function draw() {
    const dots = window.devicePixelRatio || 1;
    [canvas.width, canvas.height] = [canvas.clientWidth * dots, canvas.clientHeight * dots];
    pen.setTransform(dots, 0, 0, dots, 0, 0);
    const place = [view.x, view.y, view.scale * grid.columns, view.scale * grid.rows];
    pen.imageSmoothingEnabled = true;
    pen.drawImage(relief, ...place);
    if (current) {
      pen.imageSmoothingEnabled = false;
      pen.globalAlpha = opacity;
      pen.drawImage(current.picture, ...place);
      pen.globalAlpha = 1;
    }
    drawContours();
    for (const edge of data.release) drawLine(edge.map(toPixels), RELEASE, 2);
    for (const one of data.structures) drawStructure(one);
    for (const one of data.places) drawPlace(one);
    if (picked) drawCross(toPixels(picked));
    drawCoordinates();
    drawScale();
    drawNorth();
  }

  function drawLine(points, color, width) {
    pen.beginPath();
    points.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    [pen.strokeStyle, pen.lineWidth] = [color, width];
    pen.stroke();
  }

  function write(text, x, y, align = "center", size = 11) {
    pen.font = `${size}px system-ui, sans-serif`;
    [pen.textAlign, pen.textBaseline] = [align, "middle"];
    [pen.strokeStyle, pen.lineWidth, pen.lineJoin] = ["rgba(255,255,255,0.9)", 3, "round"];
    pen.strokeText(text, x, y);
    pen.fillStyle = INK;
    pen.fillText(text, x, y);
  }

  function drawContours() {
    for (const { level, labelled, lines } of data.contours.levels) {
      for (const flat of lines) {
        const points = [];
        for (let k = 0; k < flat.length; k += 2) points.push(toPixels([flat[k], flat[k + 1]]));
        drawLine(points, CONTOUR, labelled ? 1.1 : 0.4);
        const middle = points[Math.floor(points.length / 2)];
        if (labelled && points.length > 8) write(String(level), ...middle, "center", 10);
      }
    }
  }

  function drawStructure({ name, rings }) {
    for (const ring of rings) {
      drawLine(ring.map(toPixels), INK, 1.5);
      pen.fillStyle = "white";
      pen.fill();
    }
    if (rings.length) write(name, toPixels(rings[0][0])[0] + 6, toPixels(rings[0][0])[1] + 12, "left");
  }

  function drawPlace({ name, line }) {
    const points = line.map(toPixels);
    if (points.length > 1) {
      drawLine(points, "white", 4);
      drawLine(points, INK, 2);
    } else {
      pen.beginPath();
      pen.arc(...points[0], 5, 0, 2 * Math.PI);
      [pen.fillStyle, pen.strokeStyle, pen.lineWidth] = ["white", INK, 2];
      pen.fill();
      pen.stroke();
    }
    write(name, points[0][0] + 9, points[0][1] - 9, "left");
  }

  function drawCross([x, y]) {
    for (const [color, width] of [["white", 4], [INK, 1.5]]) {
      drawLine([[x - 7, y], [x + 7, y]], color, width);
      drawLine([[x, y - 7], [x, y + 7]], color, width);
    }
  }

  // the greatest of 1, 2, 5, 10 and so on that is not more
  function roundLength(most) {
    const power = 10 ** Math.floor(Math.log10(most));
    return [5, 2, 1].map((step) => step * power).find((length) => length <= most);
  }

  const grouped = (value) => Math.round(value).toLocaleString("en").replaceAll(",", "\u2009");

  function drawCoordinates() {
    const step = roundLength((130 / view.scale) * grid.cell);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const [west, north] = toCells(0, 0), [east, south] = toCells(width, height);
    const least = grid.west + west * grid.cell, most = grid.west + east * grid.cell;
    for (let value = Math.ceil(least / step) * step; value <= most; value += step) {
      const x = toPixels([(value - grid.west) / grid.cell, 0])[0];
      drawLine([[x, 0], [x, 6]], INK, 1);
      if (x > 60) write(grouped(value), x, 13);
    }
    const top = grid.north - north * grid.cell, bottom = grid.north - south * grid.cell;
    for (let value = Math.ceil(bottom / step) * step; value <= top; value += step) {
      const y = toPixels([0, (grid.north - value) / grid.cell])[1];
      drawLine([[0, y], [6, y]], INK, 1);
      if (y > 24 && y < height - 46) write(grouped(value), 9, y, "left");
    }
  }

  function drawScale() {
    const length = roundLength((160 / view.scale) * grid.cell);
    const pixels = (length / grid.cell) * view.scale, y = canvas.clientHeight - 16;
    pen.fillStyle = "rgba(255,255,255,0.88)";
    pen.fillRect(8, y - 24, pixels + 66, 34);
    for (let part = 0; part < 4; part++) {
      pen.fillStyle = part % 2 ? "white" : INK;
      pen.fillRect(18 + (part * pixels) / 4, y, pixels / 4, 6);
    }
    [pen.strokeStyle, pen.lineWidth] = [INK, 1];
    pen.strokeRect(18, y, pixels, 6);
    for (const share of [0, 0.5, 1]) {
      const unit = share === 1 ? " m" : "";
      write(`${share * length}${unit}`, 18 + share * pixels, y - 10);
    }
  }

  function drawNorth() {
    const [x, y] = [canvas.clientWidth - 22, canvas.clientHeight - 14];
    for (const [side, color] of [[-1, INK], [1, "white"]]) {
      pen.beginPath();
      pen.moveTo(x, y - 26);
      pen.lineTo(x + 7 * side, y);
      pen.lineTo(x, y - 6);
      pen.closePath();
      [pen.fillStyle, pen.strokeStyle, pen.lineWidth] = [color, INK, 1];
      pen.fill();
      pen.stroke();
    }
    write("N", x, y - 34);
  }

  // ---- the side: key, values, controls

  function made(name, text, parent) {
    const one = document.createElement(name);
    if (text !== undefined) one.textContent = text;
    if (parent) parent.append(one);
    return one;
  }

  const titled = ({ title, unit }) => (unit ? `${title}, ${unit}` : title);
  const shortened = (value) => String(Number(value.toPrecision(3)));

  function drawKey() {
    const box = element("key");
    box.replaceChildren();
    if (current) {
      made("strong", titled(current), box);
      const { bounds, colors, names } = current;
      for (let k = colors.length - 1; k >= 0; k--) {
        const row = made("div", undefined, box);
        made("i", undefined, row).style.background = colors[k];
        const range = k + 1 < bounds.length ? `${bounds[k]} – ${bounds[k + 1]}` : `> ${bounds[k]}`;
        made("span", names[k] || range, row);
      }
      if (current.isDepth) made("small", words.less, box);
    }
    const signs = [["contour", words.contours.replace("{interval}", data.contours.interval)]];
    if (data.release.length) signs.push(["line", words.release]);
    for (const [kind, text] of signs) {
      const row = made("div", undefined, box);
      made("i", undefined, row).className = kind;
      made("span", text, row);
    }
  }

  function valueAt(layer, cell) {
    const value = layer.values.at(cell);
    if (Number.isNaN(value)) return words.no_value;
    return layer.names[Math.round(value) - 1] || `${shortened(value)} ${layer.unit}`;
  }

  function placeAt([x, y]) {
    const east = grouped(grid.west + x * grid.cell), north = grouped(grid.north - y * grid.cell);
    return `${words.east} ${east} m, ${words.north} ${north} m`;
  }

  function readOut(point) {
    const cell = cellAt(point);
    if (cell < 0) return;
    const lines = [placeAt(point)];
    if (!Number.isNaN(elevation.at(cell))) {
      lines.push(`${words.elevation} ${elevation.at(cell).toFixed(1)} m`);
    }
    if (current) lines.push(`${current.title}: ${valueAt(current, cell)}`);
    element("readout").textContent = lines.join("\n");
  }

  function choice(layer, text) {
    const label = made("label", undefined, element("layers"));
    const button = made("input", undefined, label);
    [button.type, button.name, button.checked] = ["radio", "layer", layer === current];
    button.value = layer ? layer.name : "";
    button.addEventListener("change", () => {
      current = layer;
      update();
    });
    label.append(` ${text}`);
  }

  function update() {
    element("timing").hidden = !frames || current !== frames;
    if (frames) element("clock").textContent = `${words.time} ${frames.times[frames.frame]} s`;
    drawKey();
    draw();
  }

  for (const layer of layers) choice(layer, layer.title);
  if (frames) choice(frames, `${frames.title} (${words.time})`);
  choice(null, words.terrain);
  element("opacity").addEventListener("input", (event) => {
    opacity = event.target.value / 100;
    draw();
  });
  element("whole").addEventListener("click", () => {
    showAll();
    draw();
  });
  if (frames) {
    const slider = element("slider"), player = element("play");
    slider.max = frames.times.length - 1;
    slider.addEventListener("input", () => {
      showFrame(Number(slider.value));
      update();
    });
    let clock = null;
    player.addEventListener("click", () => {
      clearInterval(clock);
      clock = clock ? null : setInterval(() => {
        slider.value = (Number(slider.value) + 1) % frames.times.length;
        slider.dispatchEvent(new Event("input"));
      }, 250);
      player.textContent = clock ? words.pause : words.play;
    });
  }

  // ---- mouse and fingers

  let drag = null;
  canvas.addEventListener("pointerdown", (event) => {
    drag = { x: event.offsetX, y: event.offsetY, moved: false };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (drag) {
      const [dx, dy] = [event.offsetX - drag.x, event.offsetY - drag.y];
      if (drag.moved || Math.hypot(dx, dy) > 4) {
        view.x += dx;
        view.y += dy;
        drag = { x: event.offsetX, y: event.offsetY, moved: true };
        draw();
      }
    }
    readOut(toCells(event.offsetX, event.offsetY));
  });
  canvas.addEventListener("pointerup", (event) => {
    if (drag && !drag.moved) pick(event.offsetX, event.offsetY);
    drag = null;
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const factor = event.deltaY < 0 ? 1.25 : 0.8;
    view.x = event.offsetX - factor * (event.offsetX - view.x);
    view.y = event.offsetY - factor * (event.offsetY - view.y);
    view.scale *= factor;
    draw();
  }, { passive: false });

  // ---- values and curves of a place that was clicked

  function distance([x, y], line) {
    const [[ax, ay], [bx, by]] = [line[0], line[line.length - 1]];
    const length = (bx - ax) ** 2 + (by - ay) ** 2;
    const along = length ? ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length : 0;
    const share = Math.min(Math.max(along, 0), 1);
    return Math.hypot(x - ax - share * (bx - ax), y - ay - share * (by - ay));
  }

  function pick(x, y) {
    const box = element("picked");
    box.replaceChildren();
    const near = data.places.find(({ line }) => distance([x, y], line.map(toPixels)) < 9);
    picked = toCells(x, y);
    const cell = cellAt(picked);
    if (near) {
      made("strong", near.name, box);
      drawCurves(near.curves, box);
      picked = null;
    } else if (cell < 0) {
      picked = null;
    } else {
      made("strong", `${words.here}: ${placeAt(picked)}`, box);
      const table = made("table", undefined, box);
      for (const layer of layers) {
        const row = made("tr", undefined, table);
        made("td", layer.title, row);
        made("td", valueAt(layer, cell), row).className = "number";
      }
      const values = frames ? frames.all.map((frame) => frame.at(cell) || 0) : [];
      if (values.some((value) => value > 0)) {
        drawCurves([{ title: frames.title, unit: frames.unit, time: frames.times, values }], box);
      }
    }
    draw();
  }

  function drawCurves(curves, box) {
    const row = made("div", undefined, box);
    row.className = "curves";
    for (const curve of curves) row.append(plotted(curve));
  }

  function plotted({ title, unit, time, values }) {
    const [width, height, left, bottom, top] = [300, 150, 46, 30, 22];
    const figure = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    figure.setAttribute("width", width);
    figure.setAttribute("height", height);
    const known = values.filter((value) => value !== null);
    const [first, last] = [time[0], time[time.length - 1]];
    const low = Math.min(0, ...known), high = Math.max(...known, low + 1e-12);
    const x = (t) => left + ((t - first) / (last - first || 1)) * (width - left - 10);
    const y = (value) => height - bottom - ((value - low) / (high - low)) * (height - bottom - top);
    const add = (name, known, text) => {
      const one = document.createElementNS("http://www.w3.org/2000/svg", name);
      for (const [key, value] of Object.entries(known)) one.setAttribute(key, value);
      if (text !== undefined) one.textContent = text;
      figure.append(one);
    };
    const frame = `M${left},${top} V${height - bottom} H${width - 10}`;
    add("path", { d: frame, fill: "none", stroke: "#888" });
    let path = "", lifted = true;
    values.forEach((value, k) => {
      if (value === null) lifted = true;
      else {
        path += `${lifted ? "M" : "L"}${x(time[k]).toFixed(1)},${y(value).toFixed(1)}`;
        lifted = false;
      }
    });
    add("path", { d: path, fill: "none", stroke: "#0072b2", "stroke-width": 1.5 });
    const small = { "font-size": 11, fill: INK };
    add("text", { ...small, x: left, y: 13 }, titled({ title, unit }));
    for (const value of [low, high]) {
      add("text", { ...small, x: left - 4, y: y(value) + 4, "text-anchor": "end" }, shortened(value));
    }
    for (const value of [first, last]) {
      add("text", { ...small, x: x(value), y: height - 14, "text-anchor": "middle" }, shortened(value));
    }
    add("text", { ...small, x: (left + width) / 2, y: height - 4, "text-anchor": "middle" },
      `${words.time}, s`);
    return figure;
  }

  // ---- start

  showAll();
  update();
  new ResizeObserver(draw).observe(canvas);
  root.dataset.ready = "yes";
})();
