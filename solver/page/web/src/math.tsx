// Formulas by KaTeX, which is loaded once something is to be typeset; until then, and where it fails, their text.
import { host } from "./host";
import { useEffect, useState } from "preact/hooks";

let katex: Promise<typeof import("katex")> | undefined;

export function Formula({ tex, text }: { tex: string; text: string }) {
  const [html, setHtml] = useState<string | null>(null);
  useEffect(() => {
    let there = true;
    katex ??= import("katex");
    void katex.then(({ default: render }) => {
      const output = host.notebook ? "mathml" : "htmlAndMathml";
      const options = { output, throwOnError: false, trust: false, maxExpand: 100, strict: false, displayMode: false } as const;
      if (there) setHtml(render.renderToString(`\\displaystyle ${tex}`, options));
    });
    return () => void (there = false);
  }, [tex]);
  if (html === null) return <code>{text}</code>;
  return <span class="formula" ref={(element) => void (element && put(element, html))} />;
}

/** KaTeX escapes all that it is given; parsed apart, so that nothing in it runs. */
function put(element: HTMLElement, html: string): void {
  const parsed = new DOMParser().parseFromString(html, "text/html");
  element.replaceChildren(...parsed.body.childNodes);
}
