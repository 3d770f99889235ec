// All runs of a job, in pages of the server's: pages in which every run has ended are not read again.

import { read } from "../server";
import type { Job, Page, Run } from "../types";

const A_PAGE = 200;
/** Most runs that are held. */
export const MOST = 5_000;
const ENDED = ["done", "failed", "cancelled"];

export class AllRuns {
  private pages: Run[][] = [];
  private ended = 0;

  /** Every run that is held, in order. */
  get runs(): Run[] {
    return this.pages.flat();
  }

  async refresh(job: Job, signal: AbortSignal): Promise<void> {
    const { done, failed, cancelled, total } = job.runs;
    const ended = done + failed + cancelled;
    // Runs that are tried again have not ended any more.
    if (ended < this.ended) this.pages = [];
    this.ended = ended;
    const count = Math.ceil(Math.min(total, MOST) / A_PAGE);
    const isOver = (page: Run[] | undefined, number: number): boolean =>
      page !== undefined &&
      page.length === Math.min(A_PAGE, total - number * A_PAGE) &&
      page.every((run) => ENDED.includes(run.state));
    for (let number = 0; number < count; number++) {
      if (isOver(this.pages[number], number)) continue;
      const page = await read<Page<Run>>(`/v1/jobs/${job.id}/runs?limit=${A_PAGE}&cursor=${number * A_PAGE}`, signal);
      this.pages[number] = page.items;
      // Behind runs that all wait there are only more of them.
      if (page.items.every((run) => run.state === "queued") && this.pages[number + 1]) break;
    }
  }
}
