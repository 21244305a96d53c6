#include "raytracer/core/blocks/hole_record.hpp"

#include "common/util/log.hpp"
#include "common/voxel/changed_error.hpp"
#include "common/voxel/world.hpp"

namespace terravox::blocks {
namespace {

constexpr std::size_t kMaxReasons = 100;

}  // namespace

void HoleRecord::add(const voxel::BoxKey& key, const std::exception_ptr& failure) {
    std::string reason;
    try {
        std::rethrow_exception(failure);
    } catch (const voxel::ChangedError&) {
        m_holes.insert(key);
        if (!m_changed)
            m_changed = failure;
        return;
    } catch (const std::exception& e) {
        reason = e.what();
    } catch (...) {
        reason = "an error without a name";
    }
    // A damaged file fails with the same message for each of its boxes: it is logged once, and the
    // boxes are counted at the end.
    if (m_holes.insert(key).second && m_reasons.size() < kMaxReasons &&
        m_reasons.insert(reason).second)
        util::log_error("hole at box {}: {}", voxel::to_string(key), reason);
}

void HoleRecord::forget(const std::function<bool(const voxel::BoxKey&)>& may_forget) {
    ++m_generation;
    std::erase_if(m_holes, may_forget);
}

void HoleRecord::check_world() const {
    if (m_changed)
        std::rethrow_exception(m_changed);
}

}  // namespace terravox::blocks
