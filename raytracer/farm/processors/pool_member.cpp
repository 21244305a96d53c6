#include "raytracer/farm/processors/pool_member.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace terravox::processors {

PoolMember::PoolMember(MemberSpec spec, bool checks_only, Time now)
    : m_spec(std::move(spec)),
      m_checks_only(checks_only),
      m_speed(!m_spec.trusted),
      m_joined(now),
      m_paused(m_spec.paused) {}

std::size_t PoolMember::threads() const noexcept {
    return static_cast<std::size_t>(std::max(m_spec.threads, 1));
}

std::size_t PoolMember::max_leases() const noexcept {
    return static_cast<std::size_t>(std::max(m_spec.processor->capacity(), 1));
}

double PoolMember::latency_s() const {
    return m_spec.latency_s ? m_spec.latency_s() : 0;
}

bool PoolMember::set_late() noexcept {
    if (std::exchange(m_late, true))
        return false;
    m_on_probation = true;
    return true;
}

void PoolMember::on_idle(Time now) noexcept {
    m_late = false;
    m_speed.stop(now);
}

void PoolMember::on_answer(std::size_t pixels) noexcept {
    m_late = false;
    m_on_probation = false;
    m_speed.add_answer(pixels);
}

void PoolMember::add_band(std::size_t pixels) noexcept {
    ++m_bands;
    m_pixels += pixels;
}

bool PoolMember::take_check_request() noexcept {
    return std::exchange(m_check_requested, false);
}

const char* PoolMember::state() const noexcept {
    if (m_late)
        return "late";
    if (m_draining)
        return "draining";
    if (m_paused)
        return "paused";
    return m_speed.is_busy() ? "working" : "waiting";
}

MemberStatus PoolMember::status(MemberId id, std::size_t leases, Time now) const {
    const double here_s = std::max(std::chrono::duration<double>(now - m_joined).count(), 1e-6);
    MemberStatus out;
    out.id = id;
    out.name = m_spec.name;
    out.kind = m_spec.kind;
    out.state = state();
    out.threads = m_spec.threads;
    out.bands = m_bands;
    out.pixels = m_pixels;
    out.pixels_per_s = pixels_per_s();
    out.latency_s = latency_s();
    out.busy_share = std::min(m_speed.busy_s(now) / here_s, 1.0);
    out.leases = leases;
    return out;
}

}  // namespace terravox::processors
