#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "voxelserver/make/voxelize/points/point_load.hpp"

namespace terravox::voxelize {

/// Decodes whole files. Thread-safe.
///
/// One lock is held from the start of a decoding until its square is kept, because each decoding
/// uses all threads, and as much memory again as its square. A damaged file is not tried again.
class WholeDecoder {
public:
    /// Decodes a file.
    /// @throws Error for a damaged one
    using Load = std::function<LoadedSquare(std::size_t file)>;
    /// Keeps a decoded square.
    /// @return the square to use instead of the given one
    using Keep =
        std::function<std::shared_ptr<const store::Square>(std::size_t file, LoadedSquare loaded)>;
    WholeDecoder(std::size_t files, Load load, Keep keep);

    /// Blocks while another file is being decoded.
    /// @throws Error for a damaged file, each time with the same message; whatever `load` and
    /// `keep` throw
    [[nodiscard]] std::shared_ptr<const store::Square> decode(std::size_t file);

private:
    [[nodiscard]] LoadedSquare load(std::size_t file);

    const Load m_load;
    const Keep m_keep;
    std::mutex m_mutex;
    std::vector<std::string> m_failures;  ///< by file: why it could not be decoded; "": it could
};

}  // namespace terravox::voxelize
