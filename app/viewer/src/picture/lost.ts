// A browser may take the graphics memory away, for instance after sleep; three.js fills it again when it comes back.

/** Says over the canvas that its picture is gone, as long as it is. @param redraw  once it is back */
export function sayWhenLost(canvas: HTMLCanvasElement, redraw: () => void): void {
  const notice = document.createElement('p');
  notice.className = 'lost';
  notice.setAttribute('role', 'alert');
  notice.hidden = true;
  canvas.after(notice);
  canvas.addEventListener('webglcontextlost', (event) => {
    event.preventDefault(); // asks for it to be given back
    notice.textContent = 'The graphics card has dropped the picture. It comes back by itself; if it does not, load the page again.';
    notice.hidden = false;
  });
  canvas.addEventListener('webglcontextrestored', () => {
    notice.hidden = true;
    redraw();
  });
}
