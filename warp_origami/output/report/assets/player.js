// Time: which frame is shown, playing, speed.

class Player {
  // `times` of the frames; `onFrame(frame)` is told of every change.
  constructor(times, onFrame) {
    Object.assign(this, { times, onFrame, first: 0, last: times.length - 1, frame: 0, playing: false });
    this.slider = document.getElementById("time");
    this.button = document.getElementById("play");
    this.speed = document.getElementById("speed");
    this.loop = document.getElementById("loop");
    this.fillSpeeds();
    this.restrict(0, this.last);
    this.slider.addEventListener("input", () => {
      this.pause();
      this.show(Number(this.slider.value));
    });
    this.button.addEventListener("click", () => this.toggle());
    this.pause();
  }

  // Only frames first..last are played.
  restrict(first, last) {
    Object.assign(this, { first, last });
    this.slider.min = first;
    this.slider.max = last;
    for (const control of [this.slider, this.button, this.speed]) control.disabled = last <= first;
    this.show(Math.min(Math.max(this.frame, first), last));
  }

  fillSpeeds() {
    const whole = this.times.at(-1) - this.times[0] || 1;
    let rates; // [time per second, label]
    let usual;
    if (run.kind === "modal") {
      rates = [0.1, 0.25, 0.5, 1, 2].map((rate) => [rate, `${rate} periods/s`]);
      usual = 0.5;
    } else if (run.kind === "static") {
      rates = [16, 8, 4, 2].map((seconds) => [whole / seconds, `all in ${seconds} s`]);
      usual = whole / 4;
    } else {
      rates = [];
      for (let power = Math.floor(Math.log10(whole / 60)); 10 ** power <= whole; power++) {
        for (const digit of [1, 2, 5]) {
          const rate = digit * 10 ** power;
          if (rate >= whole / 60 && rate <= whole) rates.push([rate, `${short(rate)} × real time`]);
        }
      }
      usual = rates.map(([rate]) => rate).reduce((a, b) => (Math.abs(Math.log((b * 8) / whole)) < Math.abs(Math.log((a * 8) / whole)) ? b : a));
    }
    for (const [rate, label] of rates) this.speed.add(new Option(label, rate, rate === usual, rate === usual));
  }

  show(frame) {
    this.frame = Math.min(Math.max(frame, this.first), this.last);
    this.slider.value = this.frame;
    this.onFrame(this.frame);
  }

  step(by) {
    this.pause();
    this.show(this.frame + by);
  }

  // Shows the last frame that is not after a time.
  seek(time) {
    this.pause();
    this.show(this.at(time));
  }

  at(time) {
    let [low, high] = [this.first, this.last];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.times[middle] <= time * (1 + 1e-9) + 1e-300) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.last <= this.first) return;
    if (this.frame >= this.last) this.show(this.first);
    this.playing = true;
    this.label();
    let time = this.times[this.frame];
    let before = performance.now();
    const tick = (now) => {
      if (!this.playing) return;
      time += (Math.max(now - before, 0) / 1000) * Number(this.speed.value);
      before = now;
      if (time >= this.times[this.last]) {
        if (!this.loop.checked) {
          this.show(this.last);
          this.pause();
          return;
        }
        const whole = this.times[this.last] - this.times[this.first];
        time = this.times[this.first] + ((time - this.times[this.first]) % whole);
      }
      const frame = this.at(time);
      if (frame !== this.frame) this.show(frame);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  pause() {
    this.playing = false;
    this.label();
  }

  label() {
    this.button.classList.toggle("playing", this.playing);
    this.button.setAttribute("aria-label", this.playing ? "Pause" : "Play");
  }
}
