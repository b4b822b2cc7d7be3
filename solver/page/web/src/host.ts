// Where the page lives: a document of its own, or a shadow tree in a cell of a notebook.
export const host = {
  root: document as Document | ShadowRoot,
  notebook: false,
  changeTheme: () => {},
};
