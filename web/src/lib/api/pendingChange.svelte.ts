// A change in two steps: the server proposes what it would do and what would be lost, a person confirms exactly that proposal (by its
// nonce). A proposal that no longer describes the state is fetched and shown again; it is never confirmed unseen.
import type { ApiClient } from "./api";
import type { ApiError } from "./http";
import { ApiRequest } from "./request.svelte";
import type { Change, ChangeProposal, ChangeResult } from "./types";

export type { ChangeResult };

export class PendingChange {
  readonly proposal = new ApiRequest<ChangeProposal>();
  readonly result = new ApiRequest<ChangeResult>();
  /** The proposal was fetched again because the first one had changed or expired. */
  outdated = $state(false);

  constructor(
    private readonly api: ApiClient,
    private readonly change: Change,
  ) {}

  async prepare(): Promise<void> {
    this.result.reset();
    await this.proposal.run(() => this.api.prepareChange(this.change));
  }

  async confirm(): Promise<ChangeResult | undefined> {
    const proposal = this.proposal.value;
    if (!proposal) return undefined;
    const result = await this.result.run(() => this.api.confirmChange(proposal.nonce));
    const error = this.result.error;
    if (error && isOutdated(error)) {
      this.outdated = true;
      await this.prepare();
    }
    return result;
  }
}

/** Whether the error says that the proposal has changed, was used or has expired. */
export function isOutdated(error: ApiError): boolean {
  return error.code === "ConfirmationOutdated" || error.code === "ConfirmationExpired";
}
