#pragma once

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

inline constexpr const char* kBatchMediaType = "application/vnd.terravox.boxes";
inline constexpr std::size_t kMaxBatchBoxes = 4096;
/// Size of the record that precedes each box (docs/formats/http.md).
inline constexpr std::size_t kBatchRecordBytes = 24;

/// POST /v2/boxes with {"boxes": [[level, bx, by, bz], ...]}: 200 a stream of records, each box as
/// soon as it is ready; 400, 413, 415, 503 too many batches at the same time. An unavailable box is
/// a record with the reason; it does not delay the others.
[[nodiscard]] Response answer_batch(Service& service, const RouteRequest& call);

}  // namespace terravox::http
