// The stream of a batch of boxes, in parts as they may come over a network.
// The first byte says how long the parts are.
#include <algorithm>

#include "common/voxel/box.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "voxelserver/make/worlds/remote/batch_client.hpp"

namespace terravox::fuzz {

void run(Input input) {
    constexpr std::size_t kRequested = 4;
    constexpr std::size_t kMaxPayload_bytes = std::size_t{1} << 20;
    if (input.empty())
        return;
    const std::size_t part_bytes = std::size_t{1} + input[0];
    const auto bytes = std::as_bytes(input.subspan(1));
    std::size_t taken = 0;
    remote::BatchStream stream(kRequested, kMaxPayload_bytes);
    const auto take = [&](const remote::BatchRecord& record) {
        ++taken;
        expect(record.payload.size() <= kMaxPayload_bytes, "no record is longer than allowed");
        if (record.status == 200)
            allow_errors([&] { (void)voxel::decompress_box(record.payload, "the input"); });
    };
    for (std::size_t at = 0; at < bytes.size(); at += part_bytes)
        stream.feed(bytes.subspan(at, std::min(part_bytes, bytes.size() - at)), take);
    expect(taken <= kRequested, "no more boxes are taken than were requested");
    expect(!stream.whole() || taken <= kRequested,
           "a whole stream has no more boxes than were requested");
}

}  // namespace terravox::fuzz
