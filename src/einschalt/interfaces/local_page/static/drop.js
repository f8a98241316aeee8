// Takes files that are dropped or chosen, sends them one by one, and opens the block.
const place = document.querySelector(".drop-place");
const said = document.getElementById("drop-said");
const texts = document.getElementById("drop").dataset;
const most = Number(texts.most);
const inputs = { choose: document.getElementById("files"), "choose-folder": document.getElementById("folder") };

const say = (text) => { said.textContent = text; };
const filled = (text, facts) => text.replace(/{(\w+)}/g, (_, name) => facts[name]);
const required = async (answer) => {
  if (answer.ok) return answer;
  const isText = answer.headers.get("content-type")?.startsWith("text/plain");
  throw new Error(isText ? await answer.text() : answer.statusText);
};

// what a folder holds; browsers give it in portions
const entriesIn = (folder) => new Promise((done, fail) => {
  const reader = folder.createReader(), all = [];
  const more = () => reader.readEntries((some) => { if (some.length) { all.push(...some); more(); } else done(all); }, fail);
  more();
});
const filesOf = async (entry, path = "") => {
  if (entry.name.startsWith(".")) return [];
  if (entry.isFile) {
    const file = await new Promise((done, fail) => entry.file(done, fail));
    return [[path + entry.name, file]];
  }
  const found = [];
  for (const one of await entriesIn(entry)) found.push(...await filesOf(one, `${path}${entry.name}/`));
  return found;
};

const send = async (files) => {
  if (!files.length) return;
  const size = files.reduce((sum, [, file]) => sum + file.size, 0);
  if (size > most) throw new Error(filled(texts.tooLarge, { size: Math.ceil(size / 1e6), most: Math.floor(most / 1e6) }));
  const { drop } = await (await required(await fetch("/drop", { method: "POST" }))).json();
  for (const [k, [name, file]] of files.entries()) {
    say(filled(texts.count, { k: k + 1, n: files.length, name }));
    const path = name.split("/").map(encodeURIComponent).join("/");
    await required(await fetch(`/drop/${drop}/${path}`, { method: "PUT", body: file }));
  }
  location.assign(`/drop/${drop}`);
};
const sent = (files) => Promise.resolve(files).then(send).catch((fault) => say(fault.message));

for (const [id, input] of Object.entries(inputs)) {
  document.getElementById(id).addEventListener("click", () => input.click());
  input.addEventListener("change", () => {
    const named = [...input.files].map((file) => [file.webkitRelativePath || file.name, file]);
    sent(named.filter(([name]) => !name.split("/").some((part) => part.startsWith("."))));
  });
}
addEventListener("dragover", (event) => { event.preventDefault(); place.classList.add("over"); });
addEventListener("dragleave", (event) => { if (!event.relatedTarget) place.classList.remove("over"); });
addEventListener("drop", (event) => {
  event.preventDefault();
  place.classList.remove("over");
  const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry()).filter(Boolean);
  sent(Promise.all(entries.map((entry) => filesOf(entry))).then((found) => found.flat()));
});
