// Sorting and finding in the table. Without this script it stands as it was written: worst first.
(() => {
  const table = document.getElementById("table");
  if (!table) return;
  const body = table.tBodies[0], rows = [...body.rows], heads = [...table.tHead.rows[0].cells];
  const value = (row, k) => row.cells[k].dataset.v ?? row.cells[k].textContent;
  const order = new Intl.Collator("en", { numeric: true, sensitivity: "base" });

  function sort(k) {
    const head = heads[k], text = head.dataset.sort === "text";
    const now = head.getAttribute("aria-sort");
    const up = now ? now === "descending" : text; // numbers begin with the largest
    const sign = up ? 1 : -1;
    const keys = new Map(rows.map((row) => [row, text ? value(row, k) : Number(value(row, k))]));
    const compare = text ? order.compare : (a, b) => a - b;
    const name = (row) => value(row, 0);
    rows.sort((a, b) => sign * compare(keys.get(a), keys.get(b)) || order.compare(name(a), name(b)));
    for (const other of heads) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    body.append(...rows);
  }

  heads.forEach((head, k) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    button.addEventListener("click", () => sort(k));
    head.append(button);
  });

  const find = document.getElementById("find"), kind = document.getElementById("kind");
  const state = document.getElementById("state"), shown = document.getElementById("shown");
  const column = (name) => heads.findIndex((head) => head.textContent.trim() === name);
  const first = 2, kinds = Number(table.dataset.kinds); // columns of the kinds of errors
  const left = column("Left"), decided = column("Decided");

  function fits(row) {
    const counts = Array.from({ length: kinds }, (_, k) => Number(row.cells[first + k].textContent));
    const found = counts.some((count) => count > 0), wanted = kind.value;
    if (!value(row, 0).toLowerCase().includes(find.value.trim().toLowerCase())) return false;
    if (wanted === "found" && !found) return false;
    if (wanted === "none" && found) return false;
    if (wanted.startsWith("k") && !counts[Number(wanted.slice(1))]) return false;
    if (!state || !state.value) return true;
    if (state.value === "left") return Number(value(row, left)) > 0;
    const all = Number(value(row, decided)) >= 1;
    return state.value === "decided" ? all : !all;
  }

  function filter() {
    let count = 0;
    for (const row of rows) {
      row.hidden = !fits(row);
      count += !row.hidden;
    }
    shown.textContent = count === rows.length ? `${count} clips` : `${count} of ${rows.length} clips`;
  }

  const form = document.getElementById("filters");
  form.addEventListener("input", filter);
  form.addEventListener("submit", (event) => event.preventDefault());
  form.hidden = false;
  filter();
})();
