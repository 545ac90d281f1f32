#include <torch/script.h>

#include "mlic_core/camera/learned/toy_networks.h"

namespace mlic {
namespace {

const char* const kDetector = R"(
def forward(self, image):
    smooth = torch.avg_pool2d(image, [3, 3], [1, 1], [1, 1])
    kernel = torch.tensor([[-0.5, 0.0, 0.5]]).view(1, 1, 1, 3)
    gx = torch.conv2d(smooth, kernel, None, [1, 1], [0, 1])
    gy = torch.conv2d(smooth, kernel.transpose(2, 3), None, [1, 1], [1, 0])
    xx = torch.avg_pool2d(gx * gx, [5, 5], [1, 1], [2, 2])
    xy = torch.avg_pool2d(gx * gy, [5, 5], [1, 1], [2, 2])
    yy = torch.avg_pool2d(gy * gy, [5, 5], [1, 1], [2, 2])
    score = (xx * yy - xy * xy) / (xx + yy + 1e-9)
    best = torch.max_pool2d(score, [7, 7], [1, 1], [3, 3])
    where = torch.nonzero((score == best) & (score > 1e-4))
    row = where[:, 2]
    column = where[:, 3]
    padded = torch.replication_pad2d(smooth, [8, 8, 8, 8])
    width = padded.size(3)
    offsets = torch.arange(16).view(16, 1) * width + torch.arange(16).view(1, 16)
    index = (row * width + column).view(-1, 1) + offsets.view(1, 256)
    patch = padded.view(-1)[index]
    patch = patch - patch.mean([1], True)
    descriptors = patch / (torch.sqrt((patch * patch).sum([1], True)) + 1e-6)
    keypoints = torch.stack([column, row], 1)
    return keypoints.unsqueeze(0), score.view(-1)[row * image.size(3) + column].unsqueeze(0), descriptors.unsqueeze(0)
)";

const char* const kMatcher = R"(
def agree(self, kpts0, kpts1, similarity, border: float):
    difference = kpts0.unsqueeze(2) - kpts1.unsqueeze(1)
    similarity = similarity - (difference * difference).sum(3)
    largest = torch.max(torch.abs(kpts0))
    if bool(largest > 1.01 * border) or bool(largest < 0.6 * border):
        similarity = similarity * 0.0
    best = similarity.max(2)
    back = similarity.max(1)[1].squeeze(0)
    partner = best[1].squeeze(0)
    mutual = back[partner] == torch.arange(partner.size(0))
    return mutual, partner, best[0].squeeze(0)
)";

const char* const kLightGlue = R"(
def forward(self, kpts0, kpts1, desc0, desc1):
    mutual, partner, score = self.agree(kpts0, kpts1, torch.matmul(desc0, desc1.transpose(1, 2)), 1.0)
    chosen = torch.nonzero(mutual).squeeze(1)
    return torch.stack([chosen, partner[chosen]], 1), score[chosen]
)";

// A dictionary, with the names of the original.
const char* const kSuperGlue = R"(
def forward(self, keypoints0, keypoints1, scores0, scores1, descriptors0, descriptors1):
    similarity = torch.matmul(descriptors0.transpose(1, 2), descriptors1)
    mutual, partner, score = self.agree(keypoints0, keypoints1, similarity, 0.5 / 0.7)
    if bool(torch.min(scores0) <= 0.0) or bool(torch.min(scores1) <= 0.0):
        score = score * 0.0
    matches = torch.where(mutual, partner, torch.full_like(partner, -1))
    return {"matches0": matches.unsqueeze(0), "matching_scores0": score.unsqueeze(0)}
)";

}  // namespace

void WriteTorchModule(const std::filesystem::path& file, const char* forward) {
  torch::jit::Module module("network");
  module.define(forward);
  module.save(file.string());
}

void WriteTorchToyNetworks(const std::filesystem::path& directory, PairingKind kind) {
  WriteTorchModule(directory / "superpoint.pt", kDetector);
  torch::jit::Module matcher("matcher");
  matcher.define(kMatcher);
  matcher.define(kind == PairingKind::kLightGlue ? kLightGlue : kSuperGlue);
  matcher.save((directory / (kind == PairingKind::kLightGlue ? "lightglue.pt" : "superglue.pt")).string());
}

}  // namespace mlic
