// The page: top bar, variable sheet, figures, and what else there is to see in tabs below. In a browser or a notebook.
import { computed, effect } from "@preact/signals";
import { render } from "preact";
import { dragging, warm } from "./drag";
import { Figure } from "./figure";
import { host } from "./host";
import { plural } from "./format";
import { Message } from "./messages";
import { Rules } from "./rules";
import { Sensitivity } from "./sensitivity";
import { Sheet } from "./sheet";
import {
  answer,
  beyond,
  dirty,
  future,
  model,
  motion,
  notice,
  openSheet,
  past,
  redo,
  save,
  setView,
  sheet,
  sheets,
  stroke,
  trouble,
  undo,
  view,
  whenMoving,
} from "./state";
import { Sweep } from "./sweep";
import { Sliders } from "./sliders";
import { connected, waiting } from "./talk";
import { Text } from "./text";
import { Why } from "./why";

const MEANINGS: Record<string, string> = {
  partial: "partly solved",
  inconsistent: "rules contradict each other",
  infeasible: "no real solution",
  singular: "not determined there",
  failed: "no answer found",
};

/** The verdict in words, and how it looks. */
const verdict = computed<[string, string]>(() => {
  if (!connected.value) return ["no connection", "bad"];
  if (trouble.value) return [trouble.value.text, "bad"];
  if (stroke.value ?? beyond.value) return [(stroke.value ?? beyond.value)!, "warn"];
  const found = answer.value;
  if (!found) return [sheet.value || waiting.value ? "…" : "no sheet is open", ""];
  if (found.status === "solved") {
    return [`solved · ${plural(found.solutions.length, "answer")} · all rules hold`, "good"];
  }
  const missing = found.undetermined.length;
  const more = found.status === "partial" && missing ? ` · ${missing} not determined` : "";
  return [`${found.status}: ${MEANINGS[found.status] ?? ""}${more}`, found.status === "partial" ? "warn" : "bad"];
});

const TABS = [
  ["rules", "Rules", Rules],
  ["sweep", "Sweep", Sweep],
  ["sensitivity", "Sensitivity", Sensitivity],
  ["why", "Why", Why],
  ["text", "Text", Text],
] as const;

function Page() {
  const figures = model.value?.figures ?? [];
  return (
    <>
      <Bar />
      <main class={figures.length ? "" : "plain"}>
        <div class="left">
          <Sliders />
          <Sheet />
          <Messages />
        </div>
        {figures.length > 0 && (
          <section class="figures" aria-label="Figures">
            {figures.map((outline, index) => (
              <Figure key={outline.name} outline={outline} index={index} />
            ))}
            {motion.value?.handles.length ? <Carry /> : null}
          </section>
        )}
      </main>
      <Tabs />
      <p class="sr" role="status" aria-live="polite">
        {dragging.value ? "" : verdict.value[0]}. {notice.value}
      </p>
    </>
  );
}

function Bar() {
  const [words, look] = verdict.value;
  const list = sheets.value;
  return (
    <header>
      {host.notebook ? <b class="sheets">{sheet.value?.name}</b> : <select
        class="sheets"
        aria-label="Sheet"
        value={sheet.value?.key ?? ""}
        onChange={(event) => void openSheet(event.currentTarget.value)}
      >
        {!sheet.value && <option value="">choose a sheet</option>}
        {list.map(({ key, name }) => (
          <option key={key} value={key}>
            {name}
          </option>
        ))}
      </select>}
      <span class={`verdict ${look}`} data-verdict>
        {words}
      </span>
      <span class="busy" aria-hidden="true">
        {waiting.value > 0 && "·"}
      </span>
      <nav aria-label="Actions">
        <button onClick={() => void undo()} disabled={!past.value.length} title="Undo (Ctrl+Z)">
          Undo
        </button>
        <button onClick={() => void redo()} disabled={!future.value.length} title="Redo (Ctrl+Y)">
          Redo
        </button>
        {host.notebook ? null : (
          <>
            <button onClick={() => void save()} disabled={!dirty.value || sheet.value?.shipped} title="Write the sheet's file (Ctrl+S)">
              Save
            </button>
            <button onClick={host.changeTheme} title="Dark or light" aria-label="Dark or light">
              ◐
            </button>
          </>
        )}
      </nav>
    </header>
  );
}

/** Messages that belong to no rule on show, or to a sheet that cannot be read. */
function Messages() {
  const found = trouble.value ? trouble.value.complaints : (answer.value?.diagnoses ?? []);
  const gave = trouble.value && !trouble.value.complaints.length;
  if (!sheet.value && !trouble.value && !waiting.value) {
    return (
      <p class="hint">
        Choose a sheet above; <code>backsolve open mine.tk</code> begins one of your own.
      </p>
    );
  }
  if (!found.length && !notice.value && !gave) return null;
  return (
    <section class="messages" aria-label="Messages">
      {gave && <p class="message error">{trouble.value!.text}</p>}
      {found.map((one) => (
        <Message key={one.code + one.printed} complaint={one} />
      ))}
      {notice.value && <p class="hint notice">{notice.value}</p>}
    </section>
  );
}

function Carry() {
  return (
    <label class="carry">
      <input type="checkbox" checked={view.value.carry} onChange={(event) => setView({ carry: event.currentTarget.checked })} />
      carry through dead centre
    </label>
  );
}

function Tabs() {
  const now = view.value.tab;
  const keys = (event: KeyboardEvent) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const at = TABS.findIndex(([key]) => key === now);
    const next = TABS[(at + step + TABS.length) % TABS.length][0];
    setView({ tab: next });
    host.root.getElementById(`tab-${next}`)?.focus();
  };
  const [, label, Panel] = TABS.find(([key]) => key === now) ?? TABS[0];
  return (
    <section class="below">
      <div class="tabs" role="tablist" aria-label="More" onKeyDown={keys}>
        {TABS.map(([key, name]) => (
          <button
            key={key}
            id={`tab-${key}`}
            role="tab"
            aria-selected={key === now}
            aria-controls="panel"
            tabIndex={key === now ? 0 : -1}
            onClick={() => setView({ tab: key })}
          >
            {name}
          </button>
        ))}
      </div>
      <div id="panel" class={`panel panel-${now}`} role="tabpanel" aria-label={label}>
        {model.value || now === "text" ? <Panel key={sheet.value?.key} /> : null}
      </div>
    </section>
  );
}

function shortcuts(event: KeyboardEvent): void {
  if (!(event.ctrlKey || event.metaKey) || event.composedPath()[0] instanceof HTMLTextAreaElement) return;
  const key = event.key.toLowerCase();
  const action = key === "z" ? (event.shiftKey ? redo : undo) : key === "y" ? redo : key === "s" ? save : null;
  if (!action) return;
  event.preventDefault();
  const field = event.composedPath()[0];
  if (field instanceof HTMLInputElement) field.blur();
  void action();
}

/** Show the page in an element. Returns what takes it down again. */
export function mount(element: HTMLElement): () => void {
  render(<Page />, element);
  const heard = (event: Event) => shortcuts(event as KeyboardEvent);
  host.root.addEventListener("keydown", heard);
  const settled = effect(() => {
    element.dataset.state = waiting.value === 0 ? "settled" : "working";
  });
  whenMoving(warm);
  return () => {
    settled();
    host.root.removeEventListener("keydown", heard);
    render(null, element);
  };
}
