#include "voxelserver/make/voxelize/columns/prepared_squares.hpp"

#include "common/util/error.hpp"
#include "common/util/log.hpp"

namespace terravox::voxelize {
namespace {

bool intact(const store::Square& square) {
    try {
        for (const store::PatchEntry& patch : square.patches())
            static_cast<void>(square.points(patch.key));
    } catch (const util::Error& e) {
        util::log_warn("{}; it is made again", e.what());
        return false;
    }
    return true;
}

}  // namespace

PreparedSquares::PreparedSquares(store::SquareFolder* folder, std::vector<std::string> names)
    : m_folder(folder), m_names(std::move(names)), m_verified(m_names.size()) {}

bool PreparedSquares::holds(std::size_t file) const {
    return m_folder != nullptr && m_folder->holds(m_names[file]);
}

std::shared_ptr<const store::Square> PreparedSquares::find(std::size_t file) {
    if (m_folder == nullptr)
        return nullptr;
    auto square = m_folder->find(m_names[file]);
    if (!square || !(m_verified[file] || intact(*square)))
        return nullptr;
    m_verified[file] = true;
    return square;
}

std::shared_ptr<const store::Square> PreparedSquares::keep(
    std::size_t file, std::shared_ptr<const store::Square> square) {
    if (m_folder == nullptr)
        return square;
    return m_folder->put(m_names[file], std::move(square));
}

}  // namespace terravox::voxelize
