// Follows a run until it ends, then loads the page that says how.
const section = document.getElementById("run");
const stage = document.getElementById("stage");
const bar = document.getElementById("progress");
const follow = async () => {
  const answer = await fetch(`/run/${section.dataset.run}/state`);
  if (!answer.ok) throw new Error(answer.statusText);
  const run = await answer.json();
  if (stage.textContent !== run.stage) stage.textContent = run.stage;
  bar.value = run.fraction;
  if (run.state === "running") setTimeout(followed, 300);
  else location.replace(location.pathname);
};
const followed = () => follow().catch(() => {
  stage.textContent = "einschalt serve does not answer: has it ended?";
});
followed();
