// The text of the sheet, checked while it is typed; it is taken over with Ctrl+Enter or after a pause.
import { untracked, useSignal, useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import { commit, dirty, doc, save, sheet, troubleOf } from "./state";
import { host } from "./host";
import { ask } from "./talk";
import { Message } from "./messages";
import type { Complaint } from "./types";

const PAUSE = 250;

export function Text() {
  const area = useRef<HTMLTextAreaElement>(null);
  const text = useSignal(doc.value.text);
  const complaints = useSignal<Complaint[]>([]);
  const timer = useRef(0);
  useSignalEffect(() => {
    const now = doc.value.text;
    untracked(() => {
      text.value = now;
      void check(now);
    });
  });
  async function check(now: string): Promise<boolean> {
    const reply = await ask<{ warnings: Complaint[] }>({ do: "check", text: now });
    if (now !== text.peek()) return false;
    complaints.value = troubleOf(reply)?.complaints ?? reply.warnings ?? [];
    return true;
  }
  const type = (now: string) => {
    text.value = now;
    clearTimeout(timer.current);
    timer.current = window.setTimeout(() => void commit({ ...doc.value, text: now }, "text"), PAUSE);
  };
  const marks = new Map(complaints.value.flatMap((one) => one.places.map((place) => [place.line, one] as const)));
  return (
    <div class="source">
      <div class="editor">
        <pre aria-hidden="true">
          {text.value.split("\n").map((line, k) => (
            <span key={k} class={marks.has(k + 1) ? "line wrong" : "line"}>
              <Coloured line={line} />
              {"\n"}
            </span>
          ))}
        </pre>
        <textarea
          ref={area}
          aria-label="Text of the sheet"
          spellcheck={false}
          wrap="off"
          value={text.value}
          onInput={(event) => type(event.currentTarget.value)}
          onKeyDown={(event) => {
            if (event.key === "s" && (event.ctrlKey || event.metaKey)) {
              event.preventDefault();
              void save();
            }
          }}
        />
      </div>
      <div class="checks" aria-live="polite">
        {complaints.value.length === 0 && <p class="hint">Nothing wrong with this text.</p>}
        {complaints.value.map((one) => (
          <Message key={one.printed} complaint={one} open />
        ))}
        {sheet.value?.shipped ? (
          <p class="hint">
            {host.notebook ? "Changes stay in this cell; its attribute text holds them." : "This sheet comes with Backsolve: it can be changed here, and not saved."}
          </p>
        ) : (
          <p>
            <button onClick={() => void save()} disabled={!dirty.value}>
              Save
            </button>
          </p>
        )}
      </div>
    </div>
  );
}

const WORDS = /^(\s*)(units|variables|rules|function|parameters|figure|use|if|then|else|call)\b/;

function Coloured({ line }: { line: string }) {
  const use = /^\s*use\b/.test(line);
  const comment = use ? -1 : line.indexOf('"');
  const code = comment < 0 ? line : line.slice(0, comment);
  const word = WORDS.exec(code);
  return (
    <>
      {word ? (
        <>
          {word[1]}
          <b>{word[2]}</b>
          {code.slice(word[0].length)}
        </>
      ) : (
        code
      )}
      {comment >= 0 && <i>{line.slice(comment)}</i>}
    </>
  );
}
