// The websocket to the server: numbered questions, each answered once.
import { signal } from "@preact/signals";
import type { Reply } from "./types";

export const waiting = signal(0);
export const connected = signal(true);

type Waiter = (reply: Reply<unknown>) => void;

const waiters = new Map<number, Waiter>();
let socket: Promise<WebSocket> | undefined;
let last = 0;
let again: (() => void) | undefined;

/** Called when a lost connection is there again. */
export function onReconnect(then: () => void): void {
  again = then;
}

function connect(): Promise<WebSocket> {
  return new Promise((resolve) => {
    const opening = new WebSocket(`ws://${location.host}/talk`);
    opening.onopen = () => {
      connected.value = true;
      resolve(opening);
    };
    opening.onmessage = (event) => {
      const reply = JSON.parse(event.data as string);
      waiters.get(reply.id)?.(reply);
      waiters.delete(reply.id);
    };
    opening.onclose = () => lost();
  });
}

function lost(): void {
  connected.value = false;
  for (const waiter of waiters.values()) waiter({ failed: "the connection was lost" });
  waiters.clear();
  socket = undefined;
  setTimeout(() => {
    socket ??= connect();
    void socket.then(() => again?.());
  }, 1000);
}

/** Ask; `quiet` questions do not count as work that the page waits for. */
export async function ask<T>(question: { do: string } & Record<string, unknown>, quiet = false): Promise<Reply<T>> {
  if (!quiet) waiting.value = waiting.peek() + 1;
  try {
    socket ??= connect();
    const open = await socket;
    const id = ++last;
    return await new Promise<Reply<T>>((resolve) => {
      waiters.set(id, (reply) => resolve(reply as Reply<T>));
      open.send(JSON.stringify({ ...question, id }));
    });
  } finally {
    if (!quiet) waiting.value = waiting.peek() - 1;
  }
}
