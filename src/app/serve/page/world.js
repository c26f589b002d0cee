/* What the page knows of the world on the server, and who is told of its news. */
export const world = {
  hello: null,
  scene: null,
  camera: null, /* where the hand has it; `shown` is the one of the picture that one sees */
  shown: null,
  size: [1, 1],
  methods: {a: "", b: ""},
  right: "",     /* what stands right of the line: "", "b", "reference", "difference", "error", "exact" */
  settings: {},
  selected: null /* {what: "object" or "light", number} */
};

const listeners = new Map();

export function on(kind, listener) {
  if (!listeners.has(kind)) listeners.set(kind, []);
  listeners.get(kind).push(listener);
}

export function tell(kind, news) {
  for (const listener of listeners.get(kind) || []) listener(news);
}

/* Before all who listen elsewhere. */
on("hello", h => {
  world.hello = h;
  world.scene = h.scene;
  world.settings = {};
});
on("scene", scene => {
  world.scene = scene;
});
