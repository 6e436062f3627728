// What a screen reader is told: the last thing that was said, once the hand rests.
let waiting = 0;

export function say(text, after = 500) {
  clearTimeout(waiting);
  waiting = setTimeout(() => {
    document.getElementById("say").textContent = text;
  }, after);
}
