#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/util/error.hpp"

/// What the fuzz targets share. A target is one source that defines run(); fuzz.cpp hands it the
/// inputs of libFuzzer.
namespace terravox::fuzz {

using Input = std::span<const std::uint8_t>;

/// Reads one input as the target's readers do. Throwing an Error is a right answer to a damaged
/// input; any other exception, a report of a sanitizer, a timeout or too much memory is a find.
void run(Input input);

/// For a reader whose refusal must not keep the target from what comes after it.
template <class Read>
void allow_errors(const Read& read) {
    try {
        read();
    } catch (const util::Error&) {  // the right answer to a damaged input
    }
}

/// Ends the process, which libFuzzer reports as a find. @param what should have been true
void expect(bool holds, const char* what);

/// The input as a file, for readers that take a path: the one of this name, overwritten.
[[nodiscard]] std::filesystem::path as_file(Input input, const std::string& name);

[[nodiscard]] inline std::string as_text(Input input) {
    return {reinterpret_cast<const char*>(input.data()), input.size()};
}

/// A copy of the input in which checksums can be made right. Without that, nearly every mutated
/// input would be refused by the first checksum, and nothing behind it would be tried: an attacker
/// computes checksums, libFuzzer does not.
class Editable {
public:
    explicit Editable(Input input) : m_bytes(input.size()) {
        if (!input.empty())
            std::memcpy(m_bytes.data(), input.data(), input.size());
    }
    [[nodiscard]] bool holds(std::uint64_t offset, std::uint64_t bytes) const noexcept {
        return offset <= m_bytes.size() && bytes <= m_bytes.size() - offset;
    }
    /// @param offset with sizeof(T) bytes behind it: holds()
    template <class T>
    [[nodiscard]] T get(std::uint64_t offset) const {
        T out;
        std::memcpy(&out, m_bytes.data() + offset, sizeof out);
        return out;
    }
    template <class T>
    void put(std::uint64_t offset, const T& value) {
        std::memcpy(m_bytes.data() + offset, &value, sizeof value);
    }
    [[nodiscard]] std::span<const std::byte> part(std::uint64_t offset, std::uint64_t bytes) const {
        return std::span(m_bytes).subspan(static_cast<std::size_t>(offset),
                                          static_cast<std::size_t>(bytes));
    }
    [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return m_bytes; }
    [[nodiscard]] Input input() const noexcept {
        return {reinterpret_cast<const std::uint8_t*>(m_bytes.data()), m_bytes.size()};
    }

private:
    std::vector<std::byte> m_bytes;
};

}  // namespace terravox::fuzz
