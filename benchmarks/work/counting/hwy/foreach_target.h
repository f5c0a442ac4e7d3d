#pragma once
// Stands for Highway's: a kernel that counts is compiled once.
