// The page that `backsolve open` serves.
import "katex/dist/katex.min.css";
import "./page.css";
import { mount } from "./app";
import { host } from "./host";
import { openSheet, sheet, sheets } from "./state";
import { ask, talkThrough, waiting } from "./talk";

talkThrough(
  (heard, lost) =>
    new Promise((resolve) => {
      const socket = new WebSocket(`ws://${location.host}/talk`);
      socket.onopen = () => resolve({ send: (question) => socket.send(JSON.stringify(question)) });
      socket.onmessage = (event) => heard(JSON.parse(event.data as string));
      socket.onclose = lost;
    }),
  // the server has new workers, which load the sheet anew
  () => sheet.value && void openSheet(sheet.value.key),
);

host.changeTheme = () => {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  root.dataset.theme = dark ? "light" : "dark";
  sessionStorage.setItem("theme", root.dataset.theme);
};

async function start(): Promise<void> {
  const theme = sessionStorage.getItem("theme");
  if (theme) document.documentElement.dataset.theme = theme;
  mount(document.body);
  waiting.value += 1;
  const reply = await ask<{ sheets: { key: string; name: string }[]; first: string }>({ do: "sheets" });
  sheets.value = reply.sheets ?? [];
  const first = sessionStorage.getItem("sheet") ?? reply.first;
  if (first) await openSheet(first);
  waiting.value -= 1;
}

void start();
