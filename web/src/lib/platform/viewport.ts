// Width classes of the window: `narrow` is too narrow for wide tables (phone, tablet), `phone` is a phone. `compact` is a phone in either
// position, where the band has one row and the navigation five screens; styles have the same condition.
import { MediaQuery } from "svelte/reactivity";

export const narrow = new MediaQuery("max-width: 1100px");
export const phone = new MediaQuery("max-width: 700px");
export const compact = new MediaQuery("(max-width: 700px) or (max-height: 500px)");
/** A phone on its side, under fingers; a low window of a laptop is none. */
export const lying = new MediaQuery("(orientation: landscape) and (max-height: 500px) and (pointer: coarse)");
