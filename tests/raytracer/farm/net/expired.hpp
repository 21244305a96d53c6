#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>

#include "raytracer/farm/net/openssl.hpp"

namespace terravox::test {

/// A certificate by the CA of a folder that make_certs() would not make, and its key, as PEM.
/// @param days  until it expires; negative: so many days ago
inline std::pair<std::string, std::string> made_by(const std::filesystem::path& folder,
                                                   const std::string& host, int days) {
    using namespace net;
    const auto to_text = [&](const char* name) {
        std::ifstream in(folder / name, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    const auto need = [](bool ok) {
        if (!ok)
            throw std::runtime_error("make a certificate for a test: " + openssl_reason());
    };
    const auto ca = parse_certificates(to_text("ca.pem"));
    const auto ca_key = parse_key(to_text("ca.key")), key = KeyPtr(EVP_EC_gen("P-256"));
    const CertificatePtr certificate(X509_new());
    need(ca.size() == 1 && ca_key && key && certificate);
    need(X509_set_version(certificate.get(), 2) == 1 &&
         ASN1_INTEGER_set(X509_get_serialNumber(certificate.get()), 7) == 1);
    need(X509_time_adj_ex(X509_getm_notBefore(certificate.get()), -10, 0, nullptr) != nullptr &&
         X509_time_adj_ex(X509_getm_notAfter(certificate.get()), days, 0, nullptr) != nullptr);
    need(X509_set_pubkey(certificate.get(), key.get()) == 1 &&
         X509_set_issuer_name(certificate.get(), X509_get_subject_name(ca.front().get())) == 1);
    X509_EXTENSION* names =
        X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, ("DNS:" + host).c_str());
    need(names != nullptr && X509_add_ext(certificate.get(), names, -1) == 1);
    X509_EXTENSION_free(names);
    need(X509_sign(certificate.get(), ca_key.get(), EVP_sha256()) > 0);
    const auto pem = [&](const auto& write) {
        const BioPtr out(BIO_new(BIO_s_mem()));
        need(write(out.get()) == 1);
        char* text = nullptr;
        const long size_bytes = BIO_get_mem_data(out.get(), &text);
        return std::string(text, static_cast<std::size_t>(size_bytes));
    };
    return {pem([&](BIO* out) { return PEM_write_bio_X509(out, certificate.get()); }),
            pem([&](BIO* out) {
                return PEM_write_bio_PKCS8PrivateKey(out, key.get(), nullptr, nullptr, 0, nullptr,
                                                     nullptr);
            })};
}

}  // namespace terravox::test
