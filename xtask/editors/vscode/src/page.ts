// The page that shows memory layouts.

/** The picture of a message's memory layout: an element of the answer to `uavspec/layout`. */
export interface Picture {
  name: string;
  svg: string;
}

const STYLE = `
body { padding: 1em; }
h2 { font-weight: 600; }
img { background: #fff; max-width: 100%; }
`;

/**
 * The page with pictures of a document. The pictures are images, so they can't run scripts or load resources. `nonce`
 * permits the style of this page only.
 */
export function page(pictures: Picture[], nonce: string): string {
  const policy = `default-src 'none'; img-src data:; style-src 'nonce-${nonce}'`;
  const body = pictures.length > 0 ? pictures.map(figure).join("\n") : `<p>${NOTHING}</p>`;
  return `<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="${policy}">
<title>Memory layout</title>
<style nonce="${nonce}">${STYLE}</style>
</head>
<body>
${body}
</body>
</html>
`;
}

const NOTHING = "This file defines no PX4 message with a memory layout, or it contains errors.";

function figure({ name, svg }: Picture): string {
  const data = Buffer.from(svg, "utf8").toString("base64");
  const text = escape(name);
  return `<h2>${text}</h2>\n<img alt="Memory layout of ${text}" src="data:image/svg+xml;base64,${data}">`;
}

function escape(text: string): string {
  return text.replace(/[&<>"']/g, (character) => `&#${character.charCodeAt(0)};`);
}
