// Numbered questions to whatever solves behind the page, each answered once.
import { signal } from "@preact/signals";
import type { Reply } from "./types";

export const waiting = signal(0);
export const connected = signal(true);

type Waiter = (reply: Reply<unknown>) => void;

/** A line to the solver: the server's websocket, or the kernel of a notebook. */
export interface Line {
  send(question: object): void;
}

/** Opens a line; tell it what is `heard`, and that it was `lost`. */
export type Open = (heard: (reply: Reply<unknown> & { id: number }) => void, lost: () => void) => Promise<Line>;

const waiters = new Map<number, Waiter>();
let line: Promise<Line> | undefined;
let last = 0;
let open: Open;
let again: (() => void) | undefined;

/** Talk through such a line; `reconnected` is called when a lost one is there again. */
export function talkThrough(opener: Open, reconnected?: () => void): void {
  open = opener;
  again = reconnected;
}

async function connect(): Promise<Line> {
  const found = await open((reply) => {
    waiters.get(reply.id)?.(reply);
    waiters.delete(reply.id);
  }, lost);
  connected.value = true;
  return found;
}

function lost(): void {
  connected.value = false;
  for (const waiter of waiters.values()) waiter({ failed: "the connection was lost" });
  waiters.clear();
  line = undefined;
  setTimeout(() => {
    line ??= connect();
    void line.then(() => again?.());
  }, 1000);
}

/** Ask; `quiet` questions do not count as work that the page waits for. */
export async function ask<T>(question: { do: string } & Record<string, unknown>, quiet = false): Promise<Reply<T>> {
  if (!quiet) waiting.value = waiting.peek() + 1;
  try {
    line ??= connect();
    const to = await line;
    const id = ++last;
    return await new Promise<Reply<T>>((resolve) => {
      waiters.set(id, (reply) => resolve(reply as Reply<T>));
      to.send({ ...question, id });
    });
  } finally {
    if (!quiet) waiting.value = waiting.peek() - 1;
  }
}
