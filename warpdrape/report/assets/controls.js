// What the controls above the 3-D view do.
"use strict";

function addControls(report) {
  const { stage, data } = report;
  const slider = byId("time");
  slider.max = Math.max(...data.runs.map((run) => run.frames.length - 1), 1);
  on(slider, "input", () => report.setShare(slider.value / slider.max));
  on(byId("play"), "click", () => report.play());
  fill(byId("field"), data.fields.map((field) => [field.name, field.title]));
  on(byId("field"), "change", async (event) => {
    report.field = data.fields.find((field) => field.name === event.target.value);
    await report.loadField();
    report.paint();
  });
  if (data.runs.length > 1) addModes(report);
  fill(byId("look"), Object.keys(LOOKS).map((name) => [name, name]));
  on(byId("look"), "change", (event) => stage.look(...LOOKS[event.target.value]));
  addSwitches(report, "plies", (view) => view.plies);
  addSwitches(report, "tools", (view) => view.tools);
  on(byId("yarns"), "change", (event) => {
    for (const view of stage.views) {
      for (const ply of view.plies) ply.yarnGroup.visible = event.target.checked;
    }
    stage.draw();
  });
  on(byId("spread"), "input", (event) => {
    const size = stage.box.getSize(new THREE.Vector3()).length();
    const gap = (event.target.value / event.target.max) * MOST_SPREAD * size;
    for (const view of stage.views) view.spread(gap);
    report.paint();
  });
  addCut(report);
  for (const id of ["low", "high"]) on(byId(id), "change", () => readScale(report));
  on(byId("save"), "click", () => report.savePicture());
  tellValues(report);
  new ResizeObserver(() => report.placeNames()).observe(byId("canvas"));
}

function addModes(report) {
  const first = report.data.runs[0].name;
  byId("mode-label").hidden = false;
  fill(byId("mode"), [
    [OWN, "each run's own values"],
    [DIFFERENCE, `difference from ${first}`],
    [MOVED, `way from the place in ${first}`],
  ]);
  on(byId("mode"), "change", async (event) => {
    report.mode = event.target.value;
    await report.loadField();
    report.paint();
  });
}

// A switch for each ply, or tool, of one name.
function addSwitches(report, id, bodiesOf) {
  const names = [...new Set(report.stage.views.flatMap((v) => bodiesOf(v).map((b) => b.name)))];
  const place = byId(id);
  place.hidden = !names.length;
  for (const name of names) {
    const label = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.checked = true;
    label.append(box, ` ${name}`);
    place.append(label);
    on(box, "change", () => {
      for (const view of report.stage.views) {
        for (const body of bodiesOf(view)) {
          if (body.name === name) body.group.visible = box.checked;
        }
      }
      report.stage.draw();
    });
  }
}

function addCut(report) {
  const { stage } = report;
  const [axis, place, other] = ["cut-axis", "cut-place", "cut-other"].map(byId);
  const { min, max } = stage.box;
  const read = () => {
    const chosen = axis.value === "" ? null : Number(axis.value);
    place.disabled = other.disabled = chosen === null;
    if (chosen !== null) {
      const [low, high] = [min.getComponent(chosen), max.getComponent(chosen)];
      const at = low + (place.value / place.max) * (high - low);
      stage.cut.set(chosen, at, other.checked ? -1 : 1);
      byId("cut-words").textContent = said(1e3 * at, "mm");
    } else {
      stage.cut.set(null);
      byId("cut-words").textContent = "";
    }
    stage.cut.apply(stage.views);
    stage.draw();
  };
  for (const each of [axis, place, other]) on(each, "input", read);
  read();
}

function readScale(report) {
  const [low, high] = [byId("low").valueAsNumber, byId("high").valueAsNumber];
  if (Number.isFinite(low) && Number.isFinite(high) && low < high) {
    report.scales[report.field.name] = [low, high];
  }
  report.showScale();
  report.paint();
}
