// The page in a cell of a notebook; the kernel answers.
import css from "./page.css";
import { mount } from "./app";
import { host } from "./host";
import { type Opened, show } from "./state";
import { talkThrough } from "./talk";
import type { Reply } from "./types";

type Heard = Reply<unknown> & { id: number };

/** What anywidget hands over. */
interface Kernel {
  get(name: "opened"): Opened;
  send(question: object): void;
  on(event: "msg:custom", heard: (reply: Heard) => void): void;
  off(event: "msg:custom", heard: (reply: Heard) => void): void;
}

function render({ model, el }: { model: Kernel; el: HTMLElement }) {
  const root = el.attachShadow({ mode: "open" });
  host.root = root;
  host.notebook = true;
  const style = document.createElement("style");
  style.textContent = css;
  const body = document.createElement("div");
  body.className = "body";
  body.style.colorScheme = darkAround(el) ? "dark" : "light";
  root.append(style, body);
  // keys belong to the page, not to the notebook's shortcuts
  el.dataset.lmSuppressShortcuts = "true";
  el.addEventListener("keydown", (event) => event.stopPropagation());
  let listener: ((reply: Heard) => void) | undefined;
  talkThrough(async (heard) => {
    listener = heard;
    model.on("msg:custom", heard);
    return { send: (question) => model.send(question) };
  });
  const unmount = mount(body);
  void show(model.get("opened"));
  return () => {
    if (listener) model.off("msg:custom", listener);
    unmount();
  };
}

/** Whether the notebook is dark: by the first ground behind the cell that is not transparent. */
function darkAround(el: HTMLElement): boolean {
  for (let at: HTMLElement | null = el; at; at = at.parentElement) {
    const [r, g, b, a = 1] = (getComputedStyle(at).backgroundColor.match(/[\d.]+/g) ?? []).map(Number);
    if (a > 0) return 0.3 * r + 0.6 * g + 0.1 * b < 110;
  }
  return false;
}

export default { render };
